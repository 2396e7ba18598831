//! The surfaces that come from files: objects that name the same file with the same settings share
//! one, so it is read and fitted once however often it stands in a scene, and prepared for rays
//! once for each degree that level of detail chooses.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;

use crate::Result;
use crate::error::InputError;
use crate::fit::{Centre, Fit, FitSettings, fit};
use crate::io::coefficients::{self, SeriesFormat};
use crate::io::input::{FilesRead, Input};
use crate::io::meshes;
use crate::mesh::{Doubles, Mesh, MeshReport};
use crate::sh::Coefficients;
use crate::surface::{Intersector, MeshSurface, ShSurface};

/// Says which series a file gives; placement, unit and axes come after the shape and are no part of
/// it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SeriesKey {
    /// The degree asked for.
    degree: usize,
    /// The expansion centre of a fit in the file's own coordinates; chosen when `None`.
    centre: Option<DVec3>,
}

/// A series from a file, and the surfaces made of it.
pub(super) struct SharedSh {
    /// The series: up to the degree asked for, or to the last that the file has something of.
    pub(super) series: Coefficients,
    /// The point of the file that is the origin of the surfaces.
    pub(super) centre: DVec3,
    /// How it was fitted, if it was.
    pub(super) fit: Option<Arc<Fit>>,
    /// By the degree they are truncated to and how rays are met.
    surfaces: Vec<(usize, Intersector, Arc<ShSurface>)>,
    /// The time it took to make them.
    preparation: Duration,
}

/// What it took to prepare the SH surfaces of a scene for rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Preparation {
    /// The surfaces, each counted once however many objects share it.
    pub surfaces: usize,
    /// The bytes of their patches.
    pub patch_bytes: usize,
    /// The time: bounds, patches and area.
    pub time: Duration,
}

impl SharedSh {
    /// Returns the surface of the series truncated to `degree`.
    ///
    /// # Errors
    /// As [`ShSurface::new`].
    pub(super) fn surface(
        &mut self,
        degree: usize,
        intersector: Intersector,
    ) -> Result<Arc<ShSurface>> {
        let known = self.surfaces.iter().find(|(d, i, _)| (*d, *i) == (degree, intersector));
        if let Some((_, _, surface)) = known {
            return Ok(surface.clone());
        }
        let started = Instant::now();
        let surface = Arc::new(ShSurface::new(&self.series.truncated(degree), intersector)?);
        self.preparation += started.elapsed();
        self.surfaces.push((degree, intersector, surface.clone()));
        Ok(surface)
    }
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
    sh: HashMap<PathBuf, Vec<(SeriesKey, SharedSh)>>,
    /// By path and whether normals are interpolated.
    meshes: HashMap<(PathBuf, bool), SharedMesh>,
    read: HashMap<PathBuf, FilesRead>,
}

impl SharedSurfaces {
    /// Returns the series of a coefficient file or a mesh, with the surfaces made of it so far.
    ///
    /// # Errors
    /// As the readers and [`fit`].
    pub(super) fn sh(
        &mut self,
        path: &Path,
        degree: usize,
        centre: Option<DVec3>,
    ) -> Result<&mut SharedSh> {
        let of_file = self.sh.entry(path.to_owned()).or_default();
        let key = SeriesKey { degree, centre };
        let place = if let Some(place) = of_file.iter().position(|(known, _)| *known == key) {
            place
        } else {
            let (shared, read) = read_sh(path, key)?;
            note(&mut self.read, path, read)?;
            of_file.push((key, shared));
            of_file.len() - 1
        };
        Ok(&mut of_file[place].1)
    }

    /// Returns what was read for a surface, by the path of its file.
    pub(super) fn read(&self, path: &Path) -> Option<&FilesRead> {
        self.read.get(path)
    }

    /// Sums up what it took to prepare the SH surfaces.
    pub(super) fn preparation(&self) -> Preparation {
        let mut all = Preparation::default();
        for (_, shared) in self.sh.values().flatten() {
            all.time += shared.preparation;
            all.surfaces += shared.surfaces.len();
            all.patch_bytes += shared.surfaces.iter().map(|(.., s)| s.patch_bytes()).sum::<usize>();
        }
        all
    }

    /// Returns the surface of a mesh, with vertex normals interpolated for shading when it is
    /// `smooth`.
    ///
    /// # Errors
    /// As the readers and [`MeshSurface::new`].
    pub(super) fn mesh(&mut self, path: &Path, smooth: bool) -> Result<SharedMesh> {
        let key = (path.to_owned(), smooth);
        if let Some(shared) = self.meshes.get(&key) {
            return Ok(shared.clone());
        }
        let (mesh, read) = meshes::read_input(Input::open_file(path)?)?;
        note(&mut self.read, path, read)?;
        let shared = build_mesh(mesh, smooth)?;
        self.meshes.insert(key, shared.clone());
        Ok(shared)
    }
}

/// Remembers what was read, which must be the same each time that a file is.
fn note(known: &mut HashMap<PathBuf, FilesRead>, path: &Path, read: FilesRead) -> Result<()> {
    match known.entry(path.to_owned()) {
        Entry::Vacant(place) => {
            place.insert(read);
        }
        Entry::Occupied(before) if *before.get() == read => {}
        Entry::Occupied(_) => {
            let message = "this file changed while the scene was loaded";
            let help = "run it again when nothing writes to the file";
            return Err(InputError::new(path, message).help(help).into());
        }
    }
    Ok(())
}

fn read_sh(path: &Path, SeriesKey { degree, centre }: SeriesKey) -> Result<(SharedSh, FilesRead)> {
    let input = Input::open_file(path)?;
    let ((series, centre, fit), read) = if SeriesFormat::of_extension(input.name()).is_some() {
        let (shape, read) = coefficients::read_as_stated(input)?;
        // Zeros at the end cost as much as other coefficients.
        let degree = degree.min(shape.coefficients.degree_in_use());
        ((shape.coefficients.truncated(degree), shape.centre, None), read)
    } else {
        let centre = centre.map(Centre::At);
        let settings = FitSettings { centre, ..FitSettings::of_degree(degree) };
        let (mesh, read) = meshes::read_input(input)?;
        let fit = fit(&mesh, &settings)?;
        ((fit.coefficients.clone(), fit.centre, Some(Arc::new(fit))), read)
    };
    let (surfaces, preparation) = (Vec::new(), Duration::ZERO);
    Ok((SharedSh { series, centre, fit, surfaces, preparation }, read))
}

fn build_mesh(mesh: Mesh, smooth: bool) -> Result<SharedMesh> {
    let doubles = Doubles::of(&mesh);
    let mesh = without_repeated(mesh, &doubles)?;
    let report = MeshReport::of(&mesh);
    let surface = if smooth { MeshSurface::smooth(mesh) } else { MeshSurface::new(mesh) }?;
    let mut deficiencies = report.deficiencies();
    if !doubles.repeated.is_empty() {
        deficiencies.push(format!(
            "{} faces stand twice in one place and count once (the first is face {}, counted from \
             0)",
            doubles.repeated.len(),
            doubles.repeated[0]
        ));
    }
    // Numbers of faces are those of the mesh as it is met.
    let doubles = if doubles.repeated.is_empty() { doubles } else { Doubles::of(surface.mesh()) };
    Ok(SharedMesh {
        surface: Arc::new(surface.with_back_to_back(&doubles)),
        closed: report.is_closed() && !report.is_inside_out(),
        deficiencies: deficiencies.into(),
    })
}

/// Leaves out the faces that repeat others.
fn without_repeated(mesh: Mesh, doubles: &Doubles) -> Result<Mesh> {
    if doubles.repeated.is_empty() {
        return Ok(mesh);
    }
    let mut repeated = doubles.repeated.iter().peekable();
    let faces = (0..).zip(mesh.triangles());
    let kept = faces.filter(|(face, _)| repeated.next_if(|r| *r == face).is_none());
    let kept = kept.map(|(_, corners)| *corners).collect();
    Mesh::new(mesh.positions().to_vec(), kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Series;
    use crate::surface::StepBisection;

    const CUBE: &str = "OFF\n8 6 0\n-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n\
                        -1 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";

    #[test]
    fn same_file_and_settings_share_and_any_other_setting_does_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cube.off");
        std::fs::write(&path, CUBE).expect("written");
        let mut shared = SharedSurfaces::default();
        let mut of = |degree, centre, truncation, intersector| {
            let sh = shared.sh(&path, degree, centre).expect("fits");
            let surface = sh.surface(truncation, intersector).expect("a body");
            let exact = Series::new(&sh.series.truncated(truncation)).expect("valid");
            assert_eq!(surface.body().series().value(DVec3::X), exact.value(DVec3::X));
            (surface, sh.fit.clone().expect("was fitted"))
        };
        let (first, fit) = of(4, None, 4, Intersector::Certified);
        let march = Intersector::StepBisection(StepBisection::default());
        let aside = Some(DVec3::splat(0.1));
        for (degree, centre, truncation, intersector, same_surface, same_fit) in [
            (4, None, 4, Intersector::Certified, true, true),
            (4, None, 4, march, false, true),
            (4, None, 2, Intersector::Certified, false, true),
            (5, None, 4, Intersector::Certified, false, false),
            (4, aside, 4, Intersector::Certified, false, false),
        ] {
            let (surface, other_fit) = of(degree, centre, truncation, intersector);
            let told = (Arc::ptr_eq(&first, &surface), Arc::ptr_eq(&fit, &other_fit));
            assert_eq!(told, (same_surface, same_fit), "{degree} {centre:?} {truncation}");
        }
        let [flat, smooth, flat_again] =
            [false, true, false].map(|smooth| shared.mesh(&path, smooth).expect("a mesh").surface);
        assert!(Arc::ptr_eq(&flat, &flat_again) && !Arc::ptr_eq(&flat, &smooth));
    }

    #[test]
    fn file_that_changes_between_two_readings_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cube.off");
        std::fs::write(&path, CUBE).expect("written");
        let mut shared = SharedSurfaces::default();
        let first = shared.mesh(&path, false).expect("a mesh");
        shared.sh(&path, 2, None).expect("the same file");
        std::fs::write(&path, format!("{CUBE}# other")).expect("written");
        for message in [
            shared.mesh(&path, true).err().expect("refused").to_string(),
            shared.sh(&path, 3, None).err().expect("refused").to_string(),
        ] {
            assert!(message.contains("changed while the scene was loaded"), "{message}");
        }
        let again = shared.mesh(&path, false).expect("known");
        assert!(Arc::ptr_eq(&first.surface, &again.surface));
        let read = shared.read(&path).expect("was read").file.to_string();
        assert!(read.starts_with(&format!("{} bytes, fnv1a64:", CUBE.len())), "{read}");
    }

    #[test]
    fn degree_above_that_of_the_file_costs_what_the_file_costs() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("egg.txt");
        let mut c = Coefficients::zeros(6);
        c.set(0, 0, 1.0, 0.0);
        c.set(3, 2, 0.0, 0.1);
        let bytes = coefficients::encode(
            &crate::fit::Shape::new(c.clone()),
            SeriesFormat::Text,
            &coefficients::WriteOptions::default(),
        );
        std::fs::write(&path, bytes.expect("encodes")).expect("written");
        let mut shared = SharedSurfaces::default();
        for (degree, used) in [(1400, 3), (3, 3), (2, 2)] {
            let sh = shared.sh(&path, degree, None).expect("is there");
            assert_eq!(sh.series.lmax(), used, "{degree}");
            assert!((sh.series.mean() - 1.0).abs() <= 1e-15);
        }
    }

    #[test]
    fn what_cannot_be_read_stays_an_error_however_often_it_is_asked_for() {
        let mut shared = SharedSurfaces::default();
        for _ in 0..2 {
            assert!(shared.sh(Path::new("no such file.obj"), 2, None).is_err());
            assert!(shared.mesh(Path::new("no such file.obj"), true).is_err());
        }
    }
}
