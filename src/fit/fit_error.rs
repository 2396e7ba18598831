//! How far a series is from the mesh it stands for, by quadrature over the faces of the mesh.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::Result;
use crate::fit::RadialMesh;
use crate::fit::face_nodes::{FINEST, fold_faces, points_per_side};
use crate::sh::{Coefficients, Evaluator, volume};

/// The most points along each side of a face at which a radius is compared: enough for its mean
/// square, whatever the degree.
const MEASURED: usize = 6;

/// The degree up to which normals and area follow every oscillation of the series over large faces,
/// and what part of a higher degree they follow.
const FOLLOWED: (usize, f64) = (200, 0.6);

/// How many points fewer are enough for normals and area, along each side of a face, at least two.
const FEWER: usize = 3;

/// Bins of the histogram of angles between normals, 0 to pi: a hundredth of a degree each.
const BINS: usize = 18_000;

/// Holds how far a series is from the mesh it stands for (from its envelope, where the mesh is not
/// star-shaped).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitError {
    /// The root mean square of the radial difference over the solid angle, metres.
    pub rms: f64,
    /// The largest radial difference found at the vertices and quadrature points of the mesh,
    /// metres.
    pub max: f64,
    /// The mean square of the mesh's radius over the solid angle, m2.
    pub mean_square: f64,
    /// The mean angle between the normals of mesh and series in the same direction, radians, each
    /// part of the mesh weighted by its area.
    pub normal_mean: f64,
    /// The angle that 95 % of the mesh's area stays below, radians, to a hundredth of a degree.
    pub normal_95: f64,
    /// The volumes inside the mesh and inside the series, m3.
    pub volume: [f64; 2],
    /// The areas of the mesh and of the series, m2.
    pub area: [f64; 2],
}

impl FitError {
    /// Returns the truncation error by Parseval, metres: the root of what the mean square of the
    /// radius has more than the series. It is the RMS error of a projection, up to quadrature; of
    /// other series it says nothing.
    pub fn by_parseval(&self, coefficients: &Coefficients) -> f64 {
        (self.mean_square - coefficients.energy() / (4.0 * PI)).max(0.0).sqrt()
    }
}

/// Measures the difference between a series and the mesh, both about the mesh's centre.
///
/// # Errors
/// [`crate::Error::Parameter`] for a degree too high to evaluate.
pub fn fit_error(radius: &RadialMesh, coefficients: &Coefficients) -> Result<FitError> {
    let series = Evaluator::new(coefficients)?;
    let radii = Radii::of(radius, &series, coefficients.lmax());
    let normals = Normals::of(radius, &series, coefficients.lmax());
    Ok(FitError {
        rms: (radii.squares / radii.sphere).sqrt(),
        max: radii.max.max(largest_at_vertices(radius, &series)),
        mean_square: radii.square_radius / radii.sphere,
        normal_mean: normals.mean(),
        normal_95: normals.quantile(0.95),
        volume: [radii.volume, volume(coefficients)?],
        area: [normals.mesh_area, normals.series_area],
    })
}

/// Chooses the points along each side of a face: what is measured is not needed to more than some
/// digits, whatever the degree, so that only the face itself must be followed.
fn points_measured(corners: &[DVec3; 3], lmax: usize) -> usize {
    match points_per_side(corners, lmax) {
        few @ ..=FINEST => few.min(MEASURED.max(points_per_side(corners, 0))),
        many => many,
    }
}

/// Sums over the solid angle.
#[derive(Debug, Clone, Copy, Default)]
struct Radii {
    sphere: f64,
    squares: f64,
    square_radius: f64,
    volume: f64,
    max: f64,
}

impl Radii {
    fn of(radius: &RadialMesh, series: &Evaluator, lmax: usize) -> Self {
        let points = |corners: &[DVec3; 3]| points_measured(corners, lmax);
        let task = |range: std::ops::Range<usize>| {
            let mut sums = Self::default();
            for face in range {
                radius.visit(face, &points, &mut |node| {
                    let difference = node.radius - series.value(node.direction);
                    sums.sphere += node.solid_angle;
                    sums.squares += node.solid_angle * difference * difference;
                    sums.square_radius += node.solid_angle * node.radius.powi(2);
                    sums.volume += node.solid_angle * node.radius.powi(3) / 3.0;
                    sums.max = sums.max.max(difference.abs());
                });
            }
            sums
        };
        let mut total = Self::default();
        fold_faces(radius.mesh().triangles().len(), task, |part: Self| {
            total = Self {
                sphere: total.sphere + part.sphere,
                squares: total.squares + part.squares,
                square_radius: total.square_radius + part.square_radius,
                volume: total.volume + part.volume,
                max: total.max.max(part.max),
            };
        });
        total
    }
}

fn largest_at_vertices(radius: &RadialMesh, series: &Evaluator) -> f64 {
    let difference = |vertex: &DVec3| {
        let (direction, r) = radius.at_vertex(*vertex)?;
        Some((r - series.value(direction)).abs())
    };
    let vertices = radius.mesh().used_positions();
    let differences = vertices.par_iter().filter_map(difference);
    differences.reduce(|| 0.0, f64::max)
}

/// Sums over the area of the mesh.
struct Normals {
    /// The area, m2, for each bin of angles; its vector is empty where a part saw nothing.
    bins: Vec<f64>,
    angles: f64,
    mesh_area: f64,
    series_area: f64,
}

impl Normals {
    fn new() -> Self {
        Self { bins: vec![0.0; BINS], angles: 0.0, mesh_area: 0.0, series_area: 0.0 }
    }

    fn of(radius: &RadialMesh, series: &Evaluator, lmax: usize) -> Self {
        let lmax = lmax.min(FOLLOWED.0).max((FOLLOWED.1 * lmax as f64) as usize);
        let points = |corners: &[DVec3; 3]| match points_measured(corners, lmax) {
            few @ ..=FINEST => few.saturating_sub(FEWER).max(2),
            many => many,
        };
        let task = |range: std::ops::Range<usize>| {
            let mut found = Vec::new();
            let mut areas = (0.0, 0.0);
            for face in range {
                let Some(normal) = radius.mesh().normal(face) else { continue };
                radius.visit(face, &points, &mut |node| {
                    let jet = series.jet(node.direction);
                    let slope = jet.value.hypot(jet.gradient.length());
                    let own = jet.value * node.direction - jet.gradient;
                    found.push((own.angle_between(normal), node.area));
                    // dA = f sqrt(f^2 + |grad_S f|^2) d omega.
                    areas.0 += node.area;
                    areas.1 += jet.value.abs() * slope * node.solid_angle;
                });
            }
            (found, areas)
        };
        let mut all = Self::new();
        fold_faces(radius.mesh().triangles().len(), task, |(found, areas)| {
            for (angle, area) in found {
                all.bins[((angle / PI * BINS as f64) as usize).min(BINS - 1)] += area;
                all.angles += angle * area;
            }
            all.mesh_area += areas.0;
            all.series_area += areas.1;
        });
        all
    }

    fn mean(&self) -> f64 {
        self.angles / self.mesh_area
    }

    /// Returns the angle below which this share of the area lies.
    fn quantile(&self, share: f64) -> f64 {
        let mut left = share * self.mesh_area;
        for (bin, area) in self.bins.iter().enumerate() {
            if *area > 0.0 && *area >= left {
                return (bin as f64 + left / area) * PI / BINS as f64;
            }
            left -= area;
        }
        PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Envelope, project_conforming};
    use crate::mesh::shapes;

    #[test]
    fn a_sphere_in_a_cube_has_the_errors_of_the_formulas() {
        // The cube of half edge 1 against the unit sphere: per octant of a face the solid angle
        // element is da db / r^3, r^2 = 1 + a^2 + b^2, and the angle between the normals is
        // acos(1/r).
        let cube = shapes::cube().scaled(2.0).expect("positive").translated(DVec3::splat(-1.0));
        let mut one = Coefficients::zeros(0);
        one.set(0, 0, 1.0, 0.0);
        let error = fit_error(&RadialMesh::star(&cube, DVec3::ZERO), &one).expect("degree 0");
        let rule = crate::math::quadrature::Rule::gauss_legendre(40).on(0.0, 1.0);
        let mean = |f: &dyn Fn(f64) -> f64| {
            rule.integrate(|a| rule.integrate(|b| f((1.0 + a * a + b * b).sqrt())))
        };
        let square = 6.0 * mean(&|r| (r - 1.0).powi(2) / r.powi(3)) / PI;
        assert!((error.rms - square.sqrt()).abs() <= 1e-7, "{error:?}");
        assert!((error.max - (3.0_f64.sqrt() - 1.0)).abs() <= 1e-12);
        assert!((error.normal_mean - mean(&|r| (1.0 / r).acos())).abs() <= 1e-4, "{error:?}");
        // 95 % of the face's area lies within r = 1.6177 (a square less a corner of area 0.05, by
        // bisection on the formula).
        assert!(
            error.normal_95 > error.normal_mean && error.normal_95 < (1.0 / 3.0_f64.sqrt()).acos()
        );
        assert!((error.volume[0] - 8.0).abs() <= 1e-9 && (error.area[0] - 24.0).abs() <= 1e-9);
        assert!((error.volume[1] - 4.0 / 3.0 * PI).abs() <= 1e-12);
        assert!((error.area[1] - 4.0 * PI).abs() <= 1e-6);
    }

    #[test]
    fn parseval_gives_the_error_of_a_projection() {
        let mesh = shapes::sphere(2);
        let centre = DVec3::new(0.2, -0.1, 0.15);
        let fit = project_conforming(&mesh, centre, 3).expect("fits");
        let error = fit_error(&RadialMesh::star(&mesh, centre), &fit).expect("degree 3");
        assert!((error.by_parseval(&fit) / error.rms - 1.0).abs() <= 1e-4, "{error:?}");
    }

    #[test]
    fn an_envelope_of_a_convex_mesh_has_the_same_errors() {
        let mesh = shapes::sphere(1);
        let centre = DVec3::new(0.2, -0.1, 0.15);
        let fit = project_conforming(&mesh, centre, 2).expect("fits");
        let folded = RadialMesh::folded(&mesh, centre, Envelope::Mean).expect("inside");
        let [a, b] = [&RadialMesh::star(&mesh, centre), &folded]
            .map(|radius| fit_error(radius, &fit).expect("degree 2"));
        assert!((a.rms - b.rms).abs() <= 1e-12 && (a.normal_95 - b.normal_95).abs() <= 1e-12);
        assert!((a.max - b.max).abs() <= 1e-12 && (a.volume[0] - b.volume[0]).abs() <= 1e-12);
    }
}
