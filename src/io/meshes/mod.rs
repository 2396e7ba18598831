//! Mesh files: OBJ, PLY, STL, OFF and glTF in; OBJ, PLY and STL out.
//!
//! The format is told by the content of a file, and by its extension only where the content cannot
//! tell. Readers stream: they hold the mesh, a buffer and a line, and believe no count that the
//! file is too short for. (glTF is read whole, and OBJ takes nine times the mesh: crate tobj parses
//! it.) What is read is what the file says: nothing is repaired, except that the formats without
//! shared vertices, STL and glTF, have corners at equal coordinates joined.

mod encode;
mod format;
mod gltf;
mod obj;
mod off;
mod parts;
mod ply;
mod polygon;
mod samples;
mod stl;
mod welding;

use std::path::Path;

use crate::error::shown_path;
use crate::io::input::{FilesRead, Input};
use crate::io::ply::is_ply;
use crate::io::points;
use crate::io::source::{self, Source};
use crate::mesh::Mesh;
use crate::{Result, memory};

pub use encode::{MeshColours, encode, encode_ply};
pub use format::MeshFormat;
pub use obj::read_obj;
pub use samples::SurfaceSamples;

/// Reads a mesh, in the axes and the unit that the file has, whatever its extension.
///
/// # Errors
/// [`crate::Error::Io`] when the file cannot be read; [`crate::Error::Input`] when its format is
/// not known or its content cannot be used: cut short, contradicting itself, with coordinates that
/// are not finite or vertices that are not there, without faces.
///
/// ```
/// use std::path::Path;
/// let head = harmolux::io::meshes::read(Path::new("data/head.obj"))?;
/// assert_eq!(head.triangles().len(), 32_654);
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn read(path: &Path) -> Result<Mesh> {
    parse_source(&mut Source::open(path)?)
}

/// Reads a mesh as [`read`] does, and says what was read for it: with a glTF file, its buffers
/// beside it.
///
/// # Errors
/// As [`read`].
pub fn read_input(input: Input) -> Result<(Mesh, FilesRead)> {
    let mut source = Source::new(input);
    let mesh = parse_source(&mut source)?;
    Ok((mesh, source.finish()?))
}

/// Reads a mesh from the bytes of a file; `path` gives the extension where the content cannot tell,
/// is named in errors, and says where the buffers of a glTF file are.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    parse_source(&mut Source::of_bytes(path, bytes))
}

fn parse_source(source: &mut Source) -> Result<Mesh> {
    let length = source.length();
    let name = format!("{}, a file of {length} bytes,", shown_path(source.path()));
    memory::ask(length as f64, name, |_| "take a coarser mesh".to_owned())?;
    let told = recognise(source.ahead()?, length);
    match told.or_else(|| MeshFormat::of_extension(source.name())) {
        Some(MeshFormat::Obj) => obj::parse(source),
        Some(MeshFormat::Ply) => ply::parse(source),
        Some(MeshFormat::Stl) => stl::parse(source),
        Some(MeshFormat::Off) => off::parse(source),
        Some(MeshFormat::Gltf) => gltf::parse(source),
        None => {
            let help = "meshes are read as OBJ, PLY, STL, OFF and glTF; export it as one of them";
            Err(source.fault("unrecognised mesh format", help))
        }
    }
}

/// Returns the format by the beginning of a file, 64 KiB or all of it, and its length; `None` when
/// that says nothing.
pub fn recognise(head: &[u8], length: u64) -> Option<MeshFormat> {
    let first = source::first_words(head).next().unwrap_or(b"");
    if gltf::is_binary(head) {
        Some(MeshFormat::Gltf)
    } else if is_ply(head) && !points::is_marked(head) {
        Some(MeshFormat::Ply)
    } else if stl::is_binary(head, length) || stl::is_text(head) {
        Some(MeshFormat::Stl)
    } else if off::is_off(first) {
        Some(MeshFormat::Off)
    } else if gltf::is_text(head) {
        Some(MeshFormat::Gltf)
    } else if obj::is_statement(first) {
        Some(MeshFormat::Obj)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    use crate::fit::star;
    use crate::math::{Randomness, Ray, Stream, sampling};
    use crate::mesh::MeshReport;
    use crate::surface::{MeshSurface, SampleArea, Surface};
    use glam::DVec3;

    fn head() -> Mesh {
        read(Path::new("data/head.obj")).expect("the head is there")
    }

    fn error_of(path: &Path) -> String {
        read(path).unwrap_err().to_string()
    }

    #[test]
    fn missing_file_and_folder_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing.obj");
        assert!(error_of(&missing).starts_with(&format!("{}: cannot read: ", missing.display())));
        assert!(error_of(folder.path()).contains(": this is a folder, not a file"));
    }

    #[test]
    fn format_is_told_by_content_then_by_extension() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).expect("written");
            path
        };
        let triangle = "# exported\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        assert!(read(&write("a.OBJ", triangle)).is_ok());
        assert!(read(&write("a", triangle)).is_ok());
        assert!(error_of(&write("b.ply", "")).contains("this is no PLY file"));
        assert!(read(&write("b.stl", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")).is_ok());
        assert!(error_of(&write("c.txt", "hello\n")).contains("unrecognised mesh format"));
        assert!(error_of(&write("d", "")).contains("help: meshes are read as OBJ, PLY"));
    }

    #[test]
    fn head_is_what_its_readme_says() {
        let head = head();
        let report = MeshReport::of(&head);
        assert_eq!((report.vertices, report.faces, report.euler()), (16_329, 32_654, 2));
        assert_eq!((report.components, report.deficiencies()), (1, Vec::new()));
        assert!(report.require_closed().is_ok());
        // The README gives six digits.
        assert!((head.volume() / 3.65847e-3 - 1.0).abs() <= 2e-6);
        assert!((head.area() / 0.125_775 - 1.0).abs() <= 5e-6);
        let radii = head.positions().iter().map(|p| p.length());
        assert!((radii.clone().fold(f64::MAX, f64::min) - 0.0720).abs() <= 5e-5);
        assert!((radii.fold(0.0, f64::max) - 0.1413).abs() <= 5e-5);
    }

    #[test]
    fn head_is_star_shaped_about_the_origin_and_better_about_its_best_centre() {
        let head = head();
        let origin = star::require(&head, DVec3::ZERO).expect("star-shaped");
        assert_eq!((origin.turned_faces, origin.turned_area), (0, 0.0));
        let (centre, clearance) = star::best_centre(&head).expect("a centre");
        assert!(clearance >= origin.clearance, "{clearance} {}", origin.clearance);
        let best = star::test(&head, centre).expect("faces");
        assert!(best.is_star_shaped() && best.clearance == clearance);
        // No small step improves it: the objective is concave, so this is the maximum.
        for i in 0..64 {
            let u = Stream::new(Randomness::Sobol, 3, i).next_2d();
            let step = centre + 1e-4 * sampling::uniform_sphere(u);
            let there = star::test(&head, step).expect("faces").clearance;
            assert!(there <= clearance + 1e-7, "{there} {clearance}");
        }
    }

    /// One face as a surface of its own, and a ball around it, a thousandth of the head wider than
    /// need be.
    struct Single {
        surface: MeshSurface,
        middle: DVec3,
        radius: f64,
    }

    fn single(mesh: &Mesh, face: usize) -> Single {
        let (corners, middle) = (mesh.corners(face), mesh.middle(face));
        let radius = 1e-4 + corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).expect("indices in range");
        Single { surface: MeshSurface::new(mesh).expect("an area"), middle, radius }
    }

    #[test]
    fn tree_equals_brute_force_on_the_head() {
        let head = head();
        let radius = 0.1414;
        let surface = MeshSurface::new(head.clone()).expect("a surface");
        assert_eq!((surface.area() - head.area(), surface.bounds()), (0.0, head.bounds()));
        let singles: Vec<_> = (0..head.triangles().len()).map(|f| single(&head, f)).collect();
        for i in 0..3000 {
            let [a, b, c, d] = Stream::new(Randomness::Pseudorandom, 5, i).next_4d();
            let from = radius * sampling::uniform_sphere([a, b]);
            let to = radius * sampling::uniform_sphere([c, d]);
            let mut ray = Ray::between(from, to).expect("distinct").up_to(f64::INFINITY);
            ray.origin -= [0.0, 1.0, 1e5][i as usize % 3] * ray.direction;
            let near = |s: &&Single| {
                (s.middle - ray.origin).reject_from(ray.direction).length() <= s.radius
            };
            let hits = singles.iter().enumerate().filter(|(_, s)| near(s));
            let slow = hits
                .filter_map(|(face, s)| Some((s.surface.hit(&ray)?, face as u32)))
                .min_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
            let fast = surface.hit(&ray);
            assert_eq!(fast.map(|h| h.distance), slow.map(|(h, _)| h.distance));
            assert_eq!(surface.blocked(&ray), fast.is_some());
            if let (Some(fast), Some((slow, part))) = (fast, slow) {
                assert_eq!((fast.point, fast.normal, fast.part), (slow.point, slow.normal, part));
            }
        }
    }

    #[test]
    fn no_ray_from_inside_the_head_escapes() {
        let surface = MeshSurface::new(head()).expect("a surface");
        for (i, &vertex) in surface.mesh().positions().iter().enumerate() {
            let out = Ray::new(DVec3::ZERO, vertex.normalize());
            let hit = surface.hit(&out).expect("closed");
            // Star-shaped: the vertex itself is the only thing there.
            assert!((hit.distance - vertex.length()).abs() <= 1e-9, "vertex {i}");
            assert!(surface.blocked(&out) && hit.normal.dot(out.direction) > 0.0);
        }
    }
}
