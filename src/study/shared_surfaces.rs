//! The surfaces that come from files: objects that name the same file with the same settings share one, so it is read, fitted and
//! prepared for rays once however often it stands in a scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::fit::{Fit, FitSettings, fit};
use crate::Result;
use crate::io::coefficients::{self, ReadOptions, SeriesFormat};
use crate::io::meshes;
use crate::surface::{Intersector, MeshReport, MeshSurface, ShSurface};

/// Says which SH surface a file gives; placement, unit and axes come after the shape and are no part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ShShape {
    /// The truncation degree.
    pub(super) degree: usize,
    /// The expansion centre of a fit in the file's own coordinates; chosen when `None`.
    pub(super) centre: Option<DVec3>,
    /// How rays are met.
    pub(super) intersector: Intersector,
}

/// An SH surface with where it comes from.
#[derive(Clone)]
pub(super) struct SharedSh {
    pub(super) surface: Arc<ShSurface>,
    /// The point of the file that is the origin of the surface.
    pub(super) centre: DVec3,
    /// How it was fitted, if it was.
    pub(super) fit: Option<Arc<Fit>>,
}

/// A mesh surface with what is known of its mesh.
#[derive(Clone)]
pub(super) struct SharedMesh {
    pub(super) surface: Arc<MeshSurface>,
    /// Whether it has an inside.
    pub(super) closed: bool,
    /// What is wrong with the mesh.
    pub(super) deficiencies: Arc<[String]>,
}

/// Holds the surfaces made so far. Files are told apart by their paths.
#[derive(Default)]
pub(super) struct SharedSurfaces {
    sh: HashMap<PathBuf, Vec<(ShShape, SharedSh)>>,
    /// By path and whether normals are interpolated.
    meshes: HashMap<(PathBuf, bool), SharedMesh>,
}

impl SharedSurfaces {
    /// Gives the SH surface of a coefficient file or a mesh.
    ///
    /// # Errors
    /// As the readers, [`fit`] and [`ShSurface::new`].
    pub(super) fn sh(&mut self, path: &Path, shape: &ShShape) -> Result<SharedSh> {
        let of_file = self.sh.entry(path.to_owned()).or_default();
        if let Some((_, shared)) = of_file.iter().find(|(known, _)| known == shape) {
            return Ok(shared.clone());
        }
        let shared = build_sh(path, shape)?;
        of_file.push((*shape, shared.clone()));
        Ok(shared)
    }

    /// Gives the surface of a mesh, with vertex normals interpolated for shading when it is `smooth`.
    ///
    /// # Errors
    /// As the readers and [`MeshSurface::new`].
    pub(super) fn mesh(&mut self, path: &Path, smooth: bool) -> Result<SharedMesh> {
        let key = (path.to_owned(), smooth);
        if let Some(shared) = self.meshes.get(&key) {
            return Ok(shared.clone());
        }
        let shared = build_mesh(path, smooth)?;
        self.meshes.insert(key, shared.clone());
        Ok(shared)
    }
}

fn build_sh(path: &Path, shape: &ShShape) -> Result<SharedSh> {
    let (series, centre, fit) = if SeriesFormat::of_extension(path).is_some() {
        let read = coefficients::read(path, &ReadOptions::default())?;
        (read.coefficients.truncated(shape.degree), read.centre, None)
    } else {
        let settings = FitSettings { centre: shape.centre, ..FitSettings::of_degree(shape.degree) };
        let fit = fit(&meshes::read(path)?, &settings)?;
        (fit.coefficients.clone(), fit.centre, Some(Arc::new(fit)))
    };
    let surface = Arc::new(ShSurface::new(&series, shape.intersector)?);
    Ok(SharedSh { surface, centre, fit })
}

fn build_mesh(path: &Path, smooth: bool) -> Result<SharedMesh> {
    let mesh = meshes::read(path)?;
    let report = MeshReport::of(&mesh);
    let surface = if smooth { MeshSurface::smooth(mesh) } else { MeshSurface::new(mesh) }?;
    Ok(SharedMesh {
        surface: Arc::new(surface),
        closed: report.is_closed() && !report.is_inside_out(),
        deficiencies: report.deficiencies().into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::StepBisection;

    const SHAPE: ShShape = ShShape { degree: 2, centre: None, intersector: Intersector::Certified };

    #[test]
    fn same_file_and_settings_share_and_any_other_setting_does_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cube.off");
        let cube = "OFF\n8 6 0\n-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n-1 1 1\n\
                    4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
        std::fs::write(&path, cube).expect("written");
        let mut shared = SharedSurfaces::default();
        let first = shared.sh(&path, &SHAPE).expect("fits");
        let again = shared.sh(&path, &SHAPE).expect("is there");
        assert!(Arc::ptr_eq(&first.surface, &again.surface));
        let fits = [&first, &again].map(|s| s.fit.clone().expect("was fitted"));
        assert!(Arc::ptr_eq(&fits[0], &fits[1]));
        let march = Intersector::StepBisection(StepBisection::default());
        for other in [
            ShShape { degree: 3, ..SHAPE },
            ShShape { centre: Some(DVec3::splat(0.1)), ..SHAPE },
            ShShape { intersector: march, ..SHAPE },
        ] {
            let other = shared.sh(&path, &other).expect("fits");
            assert!(!Arc::ptr_eq(&first.surface, &other.surface));
        }
        let [flat, smooth, flat_again] =
            [false, true, false].map(|smooth| shared.mesh(&path, smooth).expect("a mesh").surface);
        assert!(Arc::ptr_eq(&flat, &flat_again) && !Arc::ptr_eq(&flat, &smooth));
    }

    #[test]
    fn what_cannot_be_read_stays_an_error_however_often_it_is_asked_for() {
        let mut shared = SharedSurfaces::default();
        for _ in 0..2 {
            assert!(shared.sh(Path::new("no such file.obj"), &SHAPE).is_err());
            assert!(shared.mesh(Path::new("no such file.obj"), true).is_err());
        }
    }
}
