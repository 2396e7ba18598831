//! Judges a mesh before it is fitted: closed, manifold, oriented, free of crossings, star-shaped;
//! and shows where it is not.

use glam::DVec3;

use crate::fit::SelfIntersections;
use crate::fit::star;
use crate::fit::star::{DIRECTIONS, Folds, StarReport};
use crate::mesh::{EdgeFault, Mesh, MeshReport, edge_faults};
use crate::surface::MeshSurface;
use crate::{Error, Result, memory};

/// Sets a check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckSettings {
    /// The centre, metres, about which the mesh is to be star-shaped; any will do when `None`.
    pub centre: Option<DVec3>,
    /// Whether faces that cross are looked for.
    pub crossings: bool,
}

impl Default for CheckSettings {
    fn default() -> Self {
        Self { centre: None, crossings: true }
    }
}

/// Holds what is known about a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Its topology and deficiencies.
    pub report: MeshReport,
    /// The faces that cross, when they were looked for; `None` too when a vertex of a face is not
    /// finite.
    pub crossings: Option<SelfIntersections>,
    /// How its faces look from centres; `None` when no face has an area or a vertex of one is not
    /// finite.
    pub star: Option<StarCheck>,
}

/// Whether, and about which centre, a mesh is star-shaped.
#[derive(Debug, Clone, PartialEq)]
pub struct StarCheck {
    /// Seen from the origin.
    pub origin: StarReport,
    /// The centre with the largest clearance, and that clearance, metres.
    pub best: (DVec3, f64),
    /// The centre near the centroid that is proposed ([`star::preferred_centre`]), and its
    /// clearance, metres.
    pub preferred: (DVec3, f64),
    /// Seen from the centre that was asked for, else from the proposed one.
    pub judged: StarReport,
    /// The folds about that centre, when the mesh is not star-shaped about it.
    pub folds: Option<Folds>,
}

/// What the examination of a face takes, bytes: measured, and a quarter more.
const BYTES_EACH: f64 = 500.0;

impl Check {
    /// Examines a mesh.
    ///
    /// # Errors
    /// [`Error::Geometry`] for a mesh of which no areas can be computed; [`Error::Numeric`] when
    /// the search for the best centre fails, and as [`SelfIntersections::of`].
    pub fn of(mesh: &Mesh, settings: &CheckSettings) -> Result<Self> {
        mesh.require_measurable()?;
        let faces = mesh.triangles().len();
        let what = format_args!("checking {faces} faces");
        memory::ask_each(faces, BYTES_EACH, what, "take a coarser mesh")?;
        let crossings = settings.crossings.then(|| SelfIntersections::of(mesh));
        Ok(Self {
            report: MeshReport::of(mesh),
            crossings: crossings.map(absent_when_unfit).transpose()?.flatten(),
            star: absent_when_unfit(StarCheck::of(mesh, settings.centre))?,
        })
    }

    /// Whether the mesh is closed and manifold, its faces agree and look outwards, none cross, and
    /// it is star-shaped about the centre that was asked for, else about any.
    pub fn is_sound(&self) -> bool {
        self.report.require_closed().is_ok()
            && self.report.is_manifold()
            && self.crossings.as_ref().is_none_or(|c| c.pairs == 0)
            && self.star.as_ref().is_some_and(|s| s.judged.is_star_shaped())
    }

    /// Colours the faces: what is wrong with each, the gravest of several.
    pub fn faults(&self, mesh: &Mesh) -> Vec<Option<FaceFault>> {
        let edges = edge_faults(mesh);
        let mut faults: Vec<Option<FaceFault>> =
            edges.into_iter().map(|e| e.map(FaceFault::of_edge)).collect();
        let mut mark = |faces: &[u32], fault: FaceFault| {
            for &face in faces {
                let place = &mut faults[face as usize];
                *place = (*place).max(Some(fault));
            }
        };
        mark(&self.report.degenerate, FaceFault::Doubtful);
        mark(&self.report.duplicate, FaceFault::Doubtful);
        mark(self.crossings.as_ref().map_or(&[], |c| &c.faces), FaceFault::Crossing);
        let folds = self.star.as_ref().and_then(|s| s.folds.as_ref());
        folds.iter().flat_map(|f| &f.patches).for_each(|p| mark(&p.faces, FaceFault::Turned));
        faults
    }
}

/// Says what is wrong with a face, the gravest last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaceFault {
    /// It has no area or repeats another.
    Doubtful,
    /// It is at the boundary.
    Boundary,
    /// It shares an edge with two others or more, or with one that disagrees about the outside.
    Edge,
    /// It crosses another.
    Crossing,
    /// It turns away from the centre.
    Turned,
}

impl FaceFault {
    fn of_edge(fault: EdgeFault) -> Self {
        match fault {
            EdgeFault::Boundary => Self::Boundary,
            EdgeFault::NonManifold | EdgeFault::Inconsistent => Self::Edge,
        }
    }

    /// Returns the colour, red, green and blue from 0 to 255, that shows such a face; others are
    /// [`FAULTLESS_COLOUR`].
    pub const fn colour(self) -> [u8; 3] {
        match self {
            Self::Doubtful => [235, 205, 40],
            Self::Boundary => [240, 140, 20],
            Self::Edge => [170, 60, 200],
            Self::Crossing => [40, 90, 220],
            Self::Turned => [215, 35, 35],
        }
    }
}

/// The colour of a face that nothing is wrong with.
pub const FAULTLESS_COLOUR: [u8; 3] = [190, 190, 190];

impl StarCheck {
    fn of(mesh: &Mesh, centre: Option<DVec3>) -> Result<Self> {
        let origin = star::test(mesh, DVec3::ZERO)?;
        let (best, preferred) = star::centres(mesh)?;
        let judged = star::test(mesh, centre.unwrap_or(preferred.0))?;
        let folds = if judged.is_star_shaped() {
            None
        } else {
            Some(star::folds(&MeshSurface::new(mesh.clone())?, judged.about, DIRECTIONS))
        };
        Ok(Self { origin, best, preferred, judged, folds })
    }
}

/// Takes a shape that cannot be judged for no judgement; other failures stay.
fn absent_when_unfit<T>(judged: Result<T>) -> Result<Option<T>> {
    match judged {
        Ok(found) => Ok(Some(found)),
        Err(Error::Geometry(_)) => Ok(None),
        Err(other) => Err(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn check(mesh: &Mesh, centre: Option<DVec3>) -> Check {
        Check::of(mesh, &CheckSettings { centre, crossings: true }).expect("an answer")
    }

    #[test]
    fn sizes_whose_areas_no_number_holds_are_refused() {
        for size in [1e-200, 1e-100, 1e150, 1e300] {
            let mesh = shapes::cube().scaled(size).expect("positive");
            let error = Check::of(&mesh, &CheckSettings::default()).expect_err("refused");
            assert!(error.to_string().contains("the size of the mesh is 1.000e"), "{error}");
        }
    }

    #[test]
    fn layers_upon_each_other_are_judged() {
        let cycle = |i: u32| [0, (i + 1) % 3, (i + 2) % 3];
        let faces: Vec<[u32; 3]> = (0..3000).map(cycle).collect();
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let found = check(&Mesh::new(corners, faces).expect("in range"), None);
        assert_eq!((found.report.duplicate.len(), found.is_sound()), (999, false));
        assert_eq!(found.crossings.map(|c| c.pairs), Some(0));
        assert!(found.star.is_some_and(|s| s.folds.is_some()));
    }

    #[test]
    fn meshes_that_no_centre_can_be_judged_for_have_no_star() {
        let nan =
            Mesh::new(vec![DVec3::NAN, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).expect("in range");
        for mesh in [Mesh::default(), nan] {
            let check = check(&mesh, None);
            assert!(!check.is_sound() && check.star.is_none());
            assert_eq!(check.faults(&mesh).len(), mesh.triangles().len());
        }
    }

    #[test]
    fn sound_mesh_has_no_bad_face() {
        let cube = shapes::cube();
        let about_any = check(&cube, None);
        assert!(about_any.is_sound() && about_any.faults(&cube).iter().all(Option::is_none));
        // The origin is a corner: the cube is not star-shaped about it, nor about a point outside.
        assert!(!about_any.star.expect("faces").origin.is_star_shaped());
        let outside = check(&cube, Some(DVec3::new(0.5, 0.5, 1.5)));
        assert!(!outside.is_sound());
        let turned =
            outside.faults(&cube).iter().filter(|f| **f == Some(FaceFault::Turned)).count();
        assert_eq!(turned, 2);
    }

    #[test]
    fn faults_are_told_apart() {
        let cube = shapes::cube();
        let (positions, mut triangles) = (cube.positions().to_vec(), cube.triangles().to_vec());
        triangles.remove(8);
        triangles[10].swap(0, 1);
        let mesh = Mesh::new(positions, triangles).expect("in range");
        let faults = check(&mesh, Some(DVec3::splat(0.5))).faults(&mesh);
        let count = |fault| faults.iter().filter(|f| **f == fault).count();
        // Three faces around the hole; the turned face and its three neighbours, of which it alone
        // looks away.
        assert_eq!(count(Some(FaceFault::Turned)), 1);
        assert_eq!((count(Some(FaceFault::Boundary)), count(Some(FaceFault::Edge))), (3, 3));
        assert_eq!(count(None), 4);
    }
}
