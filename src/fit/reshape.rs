//! A shape becomes another one: truncated, seen from another centre, filtered, mirrored, turned,
//! scaled, moved.

use glam::DVec3;

use crate::fit::Shape;
use crate::math::Rotation;
use crate::sh::{Alignment, Axis, Filter, Recentred, Solid, align, mirrored, recentre, rotate};
use crate::{Error, Result};

/// Names the point that becomes the expansion centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NewCentre {
    /// A point in the axes of the shape, metres.
    Point(DVec3),
    /// The centroid of the solid body.
    Centroid,
}

/// Chooses how a shape is turned, about the origin of its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turn {
    /// By a rotation.
    By(Rotation),
    /// Until its principal axes of inertia lie along x, y, z, see [`align`].
    Align,
}

/// Lists what is done to a shape, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Steps {
    /// The degree of the result: the series is cut there, or expanded up to there about its new
    /// centre.
    pub degree: Option<usize>,
    /// Where the new expansion centre is; the surface stays where it is.
    pub centre: Option<NewCentre>,
    /// How the degrees are damped.
    pub filter: Option<Filter>,
    /// The normal of the plane through the origin of the axes at which the shape is mirrored.
    pub mirror: Option<Axis>,
    /// How it is turned.
    pub turn: Option<Turn>,
    /// By what it is multiplied, about the origin of its axes.
    pub scale: Option<f64>,
    /// Whether it is moved so that its expansion centre comes to the origin of its axes.
    pub to_origin: bool,
}

/// Holds the new shape and what was found on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Reshaped {
    /// The new shape. Its source is kept only where the surface is still that of the source.
    pub shape: Shape,
    /// How well the surface is described about its new centre, when it has one.
    pub recentred: Option<Recentred>,
    /// How it was aligned, when it was.
    pub alignment: Option<Alignment>,
    /// The rotation that was applied, when there was one.
    pub rotation: Option<Rotation>,
}

/// Takes the steps.
///
/// # Errors
/// As [`recentre`] and [`align`]; [`Error::Parameter`] for a scale that is not within 1e-100 to
/// 1e100.
pub fn reshape(shape: &Shape, steps: &Steps) -> Result<Reshaped> {
    let mut done =
        Reshaped { shape: shape.clone(), recentred: None, alignment: None, rotation: None };
    match steps.centre {
        Some(centre) => done.recentre(centre, steps.degree)?,
        None => {
            if let Some(degree) = steps.degree {
                done.shape = done.shape.truncated(degree);
            }
        }
    }
    if let Some(filter) = steps.filter {
        done.shape.coefficients = filter.apply(&done.shape.coefficients);
    }
    if let Some(axis) = steps.mirror {
        done.mirror(axis);
    }
    if let Some(turn) = steps.turn {
        done.turn(turn)?;
    }
    if let Some(factor) = steps.scale {
        done.scale(factor)?;
    }
    if steps.to_origin {
        done.place(DVec3::ZERO);
    }
    Ok(done)
}

impl Reshaped {
    fn recentre(&mut self, centre: NewCentre, degree: Option<usize>) -> Result<()> {
        let shape = &mut self.shape;
        let offset = match centre {
            NewCentre::Point(point) => point - shape.centre,
            NewCentre::Centroid => Solid::of(&shape.coefficients)?.centroid,
        };
        let degree = degree.unwrap_or_else(|| shape.coefficients.lmax());
        let recentred = recentre(&shape.coefficients, offset, degree)?;
        shape.coefficients = recentred.coefficients.clone();
        shape.centre += offset;
        shape.truncated_from = None;
        self.recentred = Some(recentred);
        Ok(())
    }

    fn mirror(&mut self, axis: Axis) {
        self.shape.coefficients = mirrored(&self.shape.coefficients, axis);
        let flip = match axis {
            Axis::X => DVec3::new(-1.0, 1.0, 1.0),
            Axis::Y => DVec3::new(1.0, -1.0, 1.0),
            Axis::Z => DVec3::new(1.0, 1.0, -1.0),
        };
        self.place(flip * self.shape.centre);
    }

    fn turn(&mut self, turn: Turn) -> Result<()> {
        let rotation = match turn {
            Turn::By(rotation) => {
                self.shape.coefficients = rotate(&self.shape.coefficients, &rotation);
                rotation
            }
            Turn::Align => {
                let alignment = align(&self.shape.coefficients)?;
                self.shape.coefficients = alignment.coefficients.clone();
                let rotation = alignment.rotation;
                self.alignment = Some(alignment);
                rotation
            }
        };
        self.place(rotation.matrix() * self.shape.centre);
        self.rotation = Some(rotation);
        Ok(())
    }

    fn scale(&mut self, factor: f64) -> Result<()> {
        if !(1e-100..=1e100).contains(&factor) {
            return Err(Error::Parameter(format!(
                "a scale must be positive and finite, found {factor}"
            )));
        }
        self.shape.coefficients = self.shape.coefficients.clone().scaled(factor);
        self.place(factor * self.shape.centre);
        Ok(())
    }

    /// Puts the expansion centre elsewhere, the surface with it.
    fn place(&mut self, centre: DVec3) {
        // A sum with +0 is never -0, which a flip would leave.
        self.shape.centre = centre + DVec3::ZERO;
        self.shape.source = None;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::fit::Source;
    use crate::sh::{Coefficients, Series};

    fn shape() -> Shape {
        let mut c = Coefficients::zeros(6);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=6 {
            for m in 0..=l {
                let k = 0.2 / (l * l) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
            }
        }
        Shape {
            centre: DVec3::new(0.5, -0.25, 2.0),
            source: Some(Source::new(Path::new("rock.obj"), b"rock")),
            ..Shape::new(c)
        }
    }

    /// The point of the surface at a direction from the centre, in the axes of the shape.
    fn point(shape: &Shape, w: DVec3) -> DVec3 {
        shape.centre + Series::new(&shape.coefficients).expect("small").value(w) * w
    }

    #[test]
    fn no_steps_change_nothing() {
        let same = reshape(&shape(), &Steps::default()).expect("nothing to fail");
        assert_eq!(same.shape, shape());
        assert_eq!((same.recentred, same.alignment, same.rotation), (None, None, None));
    }

    #[test]
    fn bad_scales_are_refused() {
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let steps = Steps { scale: Some(scale), ..Steps::default() };
            assert!(matches!(reshape(&shape(), &steps), Err(Error::Parameter(_))), "{scale}");
        }
    }

    #[test]
    fn mirror_turn_and_scale_carry_the_whole_surface_about_the_origin_of_its_axes() {
        let rotation = Rotation::about(DVec3::new(1.0, 2.0, 3.0), 0.8).expect("valid");
        let steps = Steps {
            mirror: Some(Axis::Y),
            turn: Some(Turn::By(rotation)),
            scale: Some(2.5),
            ..Steps::default()
        };
        let (before, after) = (shape(), reshape(&shape(), &steps).expect("valid").shape);
        let flip = DVec3::new(1.0, -1.0, 1.0);
        for w in [DVec3::Z, DVec3::X, DVec3::new(0.3, -0.5, 0.7).normalize()] {
            let moved = 2.5 * (rotation.matrix() * (flip * point(&before, w)));
            let found = point(&after, rotation.matrix() * (flip * w));
            assert!((moved - found).length() <= 1e-13);
        }
        assert_eq!(after.source, None);
    }

    #[test]
    fn another_centre_leaves_the_surface() {
        let c = shape().centre + DVec3::new(0.05, 0.02, -0.03);
        let steps =
            Steps { centre: Some(NewCentre::Point(c)), degree: Some(24), ..Steps::default() };
        let moved = reshape(&shape(), &steps).expect("inside");
        assert_eq!((moved.shape.centre, moved.shape.coefficients.lmax()), (c, 24));
        assert_eq!(moved.shape.source, shape().source);
        let error = moved.recentred.expect("it was").max;
        let p = point(&shape(), DVec3::new(0.6, 0.0, 0.8));
        let q = point(&moved.shape, (p - c).normalize());
        assert!((p - q).length() <= error + 1e-13 && error <= 1e-6);
    }

    #[test]
    fn centred_and_aligned_shape_has_its_inertia_on_the_diagonal() {
        let steps = Steps {
            degree: Some(24),
            centre: Some(NewCentre::Centroid),
            turn: Some(Turn::Align),
            to_origin: true,
            ..Steps::default()
        };
        let done = reshape(&shape(), &steps).expect("valid");
        assert_eq!(done.shape.centre, DVec3::ZERO);
        let solid = Solid::of(&done.shape.coefficients).expect("valid");
        assert!(solid.centroid.length() <= 1e-8, "{}", solid.centroid);
        let off = DVec3::new(
            solid.inertia_about_origin.x_axis.y,
            solid.inertia_about_origin.x_axis.z,
            solid.inertia_about_origin.y_axis.z,
        );
        assert!(off.length() <= 1e-8, "{off}");
        assert_eq!(done.rotation, done.alignment.map(|a| a.rotation));
    }

    #[test]
    fn filter_damps_the_cut_series() {
        let filter = Some(Filter::Lanczos);
        let steps = Steps { degree: Some(3), filter, ..Steps::default() };
        let done = reshape(&shape(), &steps).expect("valid").shape.coefficients;
        assert_eq!(done, Filter::Lanczos.apply(&shape().coefficients.truncated(3)));
    }

    #[test]
    fn cut_remembers_the_first_degree() {
        let cut = reshape(&shape(), &Steps { degree: Some(3), ..Steps::default() });
        assert_eq!(cut.expect("valid").shape.truncated_from, Some(6));
    }
}
