//! Rays against a mesh: the tree of `bvh` over leaves of eight triangles, which `block` tests side
//! by side.
//!
//! Error of a hit. The point is a + v (b - a) + w (c - a) with v + w <= 1 + 3u, u = 2^-53.
//! Differences, products and two sums give at most (1+u)^4 - 1 on every term (pbrt, section 6.8:
//! gamma_4), the excess over 1 moves the point by at most 3u of an edge: with gamma_7 of |a| + |b -
//! a| + |c - a| the bound holds, its own rounding included. It is a distance from the triangle, not
//! only from its plane, and neither the length of the ray nor the angle it comes at enters.

mod block;
mod spread;

use std::collections::HashSet;
use std::sync::OnceLock;

use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec2, DVec3};

use super::{AreaPoint, Bvh, Division, Facet, Hit, Outline, SampleArea, Surface, facets};
use crate::math::{Aabb, Ray, sampling};
use crate::mesh::{Doubles, Mesh};
use crate::{Error, Result, memory};
use block::{Block, LANES, Meeting, Shear};
use spread::Spread;

/// Answers rays for a mesh.
#[derive(Debug, Clone)]
pub struct MeshSurface {
    mesh: Mesh,
    tree: Bvh,
    bounds: Aabb,
    /// The leaves of the tree.
    blocks: Vec<Block>,
    /// The area of the faces up to and with each, m2.
    areas: Vec<f64>,
    /// Unit normals of the vertices, when smooth.
    vertex_normals: Option<Vec<DVec3>>,
    /// Faces that have another at their back: each side is met from its front.
    back_to_back: HashSet<u32>,
    /// The faces by place; made when first asked for.
    spread: OnceLock<Spread>,
    level: Level,
}

/// Bounds the relative error of seven roundings, 7u / (1 - 7u).
const GAMMA_7: f64 = 7.0 * (0.5 * f64::EPSILON) / (1.0 - 7.0 * (0.5 * f64::EPSILON));

impl MeshSurface {
    /// Prepares a mesh for rays; it is shaded flat.
    ///
    /// # Errors
    /// [`Error::Geometry`] when a vertex of a face is not finite or no face has an area.
    pub fn new(mesh: Mesh) -> Result<Self> {
        // Boxes, both trees while one becomes the other, and the triangles in their order.
        let count = mesh.triangles().len();
        let what = format_args!("tracing {count} triangles");
        memory::ask_each(count, 400.0, what, "take a coarser mesh")?;
        check_finite(&mesh)?;
        mesh.require_measurable()?;
        let boxes = boxes(&mesh);
        let areas = cumulative_areas(&mesh)?;
        let (tree, order) = Bvh::build_padded(&boxes);
        let leaves = order.as_chunks::<LANES>().0.iter();
        let blocks = leaves.map(|faces| Block::new(&mesh, *faces)).collect();
        let (bounds, level) = (mesh.bounds(), Level::new());
        let (vertex_normals, spread) = (None, OnceLock::new());
        let back_to_back = HashSet::new();
        Ok(Self { mesh, tree, bounds, blocks, areas, vertex_normals, back_to_back, spread, level })
    }

    /// Prepares a mesh for rays, shaded with normals interpolated between its vertices, whose own
    /// are the means of the faces around them weighted by angle (Thuermer and Wuethrich 1998).
    /// Geometry and geometric normals stay those of the faces.
    ///
    /// # Errors
    /// As [`MeshSurface::new`].
    pub fn smooth(mesh: Mesh) -> Result<Self> {
        let mut surface = Self::new(mesh)?;
        surface.vertex_normals = Some(vertex_normals(&surface.mesh));
        Ok(surface)
    }

    /// Meets faces that stand back to back, as [`Doubles`] finds them, from their front, so that
    /// each side shines by itself.
    pub fn with_back_to_back(mut self, doubles: &Doubles) -> Self {
        self.back_to_back.clone_from(&doubles.back_to_back);
        self
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Returns the bytes that rays use: the tree, and the triangles in its order.
    pub fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(&self.blocks[..])
    }

    /// Describes every vertex as a hit: its normal is the mean of the faces around it weighted by
    /// area, and its part the largest of them, whose normal it has where they cancel. `None` for a
    /// vertex of no face that has an area.
    pub fn vertices(&self) -> Vec<Option<Hit>> {
        let mut around = vec![Around::default(); self.mesh.positions().len()];
        for (face, triangle) in self.mesh.triangles().iter().enumerate() {
            let area = self.mesh.area_vector(face);
            let [a, b, c] = self.mesh.corners(face);
            let size = a.abs() + (b - a).abs() + (c - a).abs();
            for &vertex in triangle {
                around[vertex as usize].add(face as u32, area, GAMMA_7 * size.length());
            }
        }
        self.mesh.positions().iter().zip(&around).map(|(at, around)| around.hit(*at)).collect()
    }

    #[inline(always)]
    fn closest<S: Simd>(&self, simd: S, ray: &Ray) -> Option<Hit> {
        let shear = Shear::new(simd, ray);
        let mut best = None;
        self.tree.walk(
            simd,
            ray,
            #[inline(always)]
            |places, t_max| {
                let leaf = places.start / LANES;
                let Some(meeting) = self.blocks[leaf].meet(simd, &shear, ray.t_min, t_max) else {
                    return Some(t_max);
                };
                best = Some((leaf, meeting));
                Some(meeting.distance)
            },
        );
        let (leaf, meeting) = best?;
        let (face, corners) = self.blocks[leaf].face(meeting.lane);
        let hit = self.hit_at(face, corners, meeting, -ray.direction);
        if self.back_to_back.is_empty() || !self.is_met_from_behind(&hit, ray) {
            return Some(hit);
        }
        Some(Hit { normal: -hit.normal, shading_normal: -hit.shading_normal, ..hit })
    }

    #[inline(never)]
    fn is_met_from_behind(&self, hit: &Hit, ray: &Ray) -> bool {
        hit.normal.dot(ray.direction) > 0.0 && self.back_to_back.contains(&hit.part)
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, ray: &Ray) -> bool {
        let shear = Shear::new(simd, ray);
        let mut found = false;
        self.tree.walk(
            simd,
            ray,
            #[inline(always)]
            |places, t_max| {
                let block = &self.blocks[places.start / LANES];
                found = block.meet(simd, &shear, ray.t_min, t_max).is_some();
                (!found).then_some(t_max)
            },
        );
        found
    }

    /// Describes the point of a face with these weights; `back` stands in for the normal of a face
    /// without area, which only a ray between its two neighbours can meet.
    #[inline(always)]
    fn hit_at(&self, face: u32, [a, b, c]: [DVec3; 3], at: Meeting, back: DVec3) -> Hit {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac).try_normalize().unwrap_or(back);
        let size = a.abs() + ab.abs() + ac.abs();
        Hit {
            distance: at.distance,
            point: a + at.v * ab + at.w * ac,
            normal,
            shading_normal: self.shading_normal(face, at, normal),
            error: GAMMA_7 * size.length(),
            part: face,
        }
    }

    /// Describes the point of a face at a point of the unit square, evenly by area.
    fn within(&self, face: u32, u: [f64; 2]) -> Hit {
        let weights = sampling::uniform_triangle(u);
        let at = Meeting { v: weights.y, w: weights.z, ..Meeting::default() };
        self.hit_at(face, self.mesh.corners(face as usize), at, DVec3::Z)
    }

    /// Interpolates the vertex normals where there are any and they look to the side of the face.
    #[inline(always)]
    fn shading_normal(&self, face: u32, at: Meeting, normal: DVec3) -> DVec3 {
        let Some(normals) = &self.vertex_normals else { return normal };
        let [a, b, c] = self.mesh.triangles()[face as usize].map(|v| normals[v as usize]);
        let mean = (1.0 - at.v - at.w) * a + at.v * b + at.w * c;
        mean.try_normalize().filter(|n| n.dot(normal) > 0.0).unwrap_or(normal)
    }
}

impl Surface for MeshSurface {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        dispatch!(self.level, simd => self.closest(simd, ray))
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn blocked(&self, ray: &Ray) -> bool {
        dispatch!(self.level, simd => self.any(simd, ray))
    }

    fn hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        dispatch!(self.level, simd => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.closest(simd, ray);
            }
        });
    }

    fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        dispatch!(self.level, simd => {
            for (ray, blocked) in rays.iter().zip(blocked) {
                *blocked = *blocked || self.any(simd, ray);
            }
        });
    }
}

impl SampleArea for MeshSurface {
    fn area(&self) -> f64 {
        self.areas.last().copied().unwrap_or(0.0)
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let (face, rest) = sampling::discrete(&self.areas, u.x);
        AreaPoint { hit: self.within(face as u32, [rest, u.y]), density: 1.0 / self.area() }
    }

    fn density(&self, _: &Hit) -> f64 {
        1.0 / self.area()
    }

    fn outline(&self) -> Outline {
        Outline::Polygons
    }

    /// Divides each triangle that is larger than the mean facet; faces without area give none.
    fn facets(&self, division: &Division) -> Vec<Facet> {
        let largest = self.area() / division.count as f64;
        let mut into = Vec::new();
        for face in 0..self.mesh.triangles().len() {
            let corners = self.mesh.corners(face);
            if self.mesh.normal(face).is_some() {
                let meeting = |p: DVec2| Meeting { v: p.x, w: p.y, ..Meeting::default() };
                let at = |p| self.hit_at(face as u32, corners, meeting(p), DVec3::Z);
                facets::triangle(corners, largest, at, &mut into);
            }
        }
        into
    }

    /// Maps like [`SampleArea::sample_area`], with the faces in an order of places rather than that
    /// of the file: points that are evenly spread along `u.x` are so in space.
    fn uniform(&self, u: DVec2) -> Hit {
        let Spread { faces, areas } = self.spread.get_or_init(|| Spread::new(&self.mesh));
        let (place, rest) = sampling::discrete(areas, u.x);
        self.within(faces[place], [rest, u.y])
    }
}

/// Gathers the faces around a vertex.
#[derive(Debug, Clone, Copy, Default)]
struct Around {
    /// The sum of their area vectors.
    sum: DVec3,
    /// The area vector of the largest, and its number.
    largest: (DVec3, u32),
    /// The largest error bound of a hit on them.
    error: f64,
}

impl Around {
    fn add(&mut self, face: u32, area: DVec3, error: f64) {
        self.sum += area;
        self.error = self.error.max(error);
        if area.length_squared() > self.largest.0.length_squared() {
            self.largest = (area, face);
        }
    }

    fn hit(&self, point: DVec3) -> Option<Hit> {
        let (largest, part) = self.largest;
        // What roundings leave of faces that cancel is no direction.
        let clear = self.sum.length() > 1e-9 * largest.length();
        let normal = if clear { self.sum } else { largest }.try_normalize()?;
        Some(Hit { distance: 0.0, point, normal, shading_normal: normal, error: self.error, part })
    }
}

/// Bounds the faces; empty for those that no ray need be compared with: where two corners are one
/// the neighbours share the edge, and what repeats a face is met where that is.
fn boxes(mesh: &Mesh) -> Vec<Aabb> {
    let bounds = |face: usize| match mesh.corners(face) {
        [a, b, c] if a == b || b == c || c == a => Aabb::EMPTY,
        corners => Aabb::of_points(corners),
    };
    let mut boxes: Vec<_> = (0..mesh.triangles().len()).map(bounds).collect();
    for face in Doubles::of(mesh).repeated {
        boxes[face as usize] = Aabb::EMPTY;
    }
    boxes
}

/// Sums the areas face by face.
fn cumulative_areas(mesh: &Mesh) -> Result<Vec<f64>> {
    let mut sum = 0.0;
    let mut add = |face| {
        sum += mesh.area_vector(face).length();
        sum
    };
    let areas: Vec<f64> = (0..mesh.triangles().len()).map(&mut add).collect();
    if areas.last().is_some_and(|&total| total > 0.0 && total.is_finite()) {
        return Ok(areas);
    }
    Err(Error::Geometry(format!(
        "the mesh has {} faces and together they have no area that a ray could meet; give it at \
         least one triangle with three distinct corners not in a line",
        areas.len()
    )))
}

/// Rejects vertices that no ray can be compared with.
fn check_finite(mesh: &Mesh) -> Result<()> {
    let used = mesh.triangles().iter().flatten();
    match used.copied().find(|&v| !mesh.positions()[v as usize].is_finite()) {
        None => Ok(()),
        Some(vertex) => Err(Error::Geometry(format!(
            "vertex {vertex} (from 0) of the mesh is at {}, which is not finite; mend its \
             coordinates or remove the faces that use it",
            mesh.positions()[vertex as usize]
        ))),
    }
}

/// Averages the normals of the faces around each vertex by the angle they have there.
fn vertex_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions().len()];
    for (face, triangle) in mesh.triangles().iter().enumerate() {
        let Some(normal) = mesh.normal(face) else { continue };
        let corners = mesh.corners(face);
        for i in 0..3 {
            let (next, last) =
                (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            normals[triangle[i] as usize] += next.angle_between(last) * normal;
        }
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream};
    use crate::mesh::shapes;

    fn numbers() -> Stream {
        Stream::new(Randomness::Pseudorandom, 11, 0)
    }

    fn direction(stream: &mut Stream) -> DVec3 {
        sampling::uniform_sphere(stream.next_2d())
    }

    fn point(stream: &mut Stream) -> DVec3 {
        let [x, y, z, _] = stream.next_4d();
        DVec3::new(x, y, z)
    }

    /// The slow truth: the same test against every face.
    fn brute_force(surface: &MeshSurface, ray: &Ray) -> Option<f64> {
        let meet = |block: &Block| {
            dispatch!(surface.level, simd => {
                block.meet(simd, &Shear::new(simd, ray), ray.t_min, ray.t_max)
            })
        };
        surface.blocks.iter().filter_map(meet).map(|m| m.distance).reduce(f64::min)
    }

    #[test]
    fn layers_in_one_place_are_met_once() {
        // A polygon that goes round and round its three corners.
        let cycle = |i: u32| [0, (i + 1) % 3, (i + 2) % 3];
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = (0..30_000).map(cycle).chain([[0, 2, 1], [0, 1, 3]]).collect();
        let surface = MeshSurface::new(Mesh::new(corners, faces).expect("in range"));
        let surface = surface.expect("has an area");
        // What is left: one layer, its back, and the wall.
        let faces = |block: &Block| (0..LANES).map(|lane| block.face(lane).0).collect::<Vec<_>>();
        let kept: HashSet<u32> = surface.blocks.iter().flat_map(faces).collect();
        assert_eq!(kept, HashSet::from([0, 30_000, 30_001]));
        let down = Ray::new(DVec3::new(0.2, 0.3, 1.0), DVec3::NEG_Z);
        assert_eq!(surface.hit(&down).map(|hit| hit.distance), Some(1.0));
    }

    #[test]
    fn mesh_without_area_is_refused() {
        assert!(MeshSurface::new(Mesh::default()).is_err());
        let line = Mesh::new(vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], vec![[0, 1, 2]]);
        assert!(MeshSurface::new(line.expect("indices in range")).is_err());
        let nan = Mesh::new(vec![DVec3::NAN, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
        let error = MeshSurface::new(nan.expect("indices in range")).unwrap_err().to_string();
        assert!(error.starts_with("vertex 0 (from 0) of the mesh is at [NaN, NaN, NaN]"));
    }

    #[test]
    fn cube_is_hit_where_it_is() {
        let cube = MeshSurface::new(shapes::cube()).expect("a surface");
        let hit = cube.hit(&Ray::new(DVec3::new(0.25, 0.5, 3.0), DVec3::NEG_Z)).expect("above");
        assert_eq!((hit.distance, hit.normal, hit.shading_normal), (2.0, DVec3::Z, DVec3::Z));
        assert!((hit.point - DVec3::new(0.25, 0.5, 1.0)).length() <= hit.error);
        // From inside the normal still looks out.
        let hit = cube.hit(&Ray::new(DVec3::splat(0.4), DVec3::X)).expect("inside");
        assert_eq!((hit.normal, hit.distance), (DVec3::X, 0.6));
        assert!(cube.hit(&Ray::new(DVec3::splat(0.4), DVec3::X).up_to(0.59)).is_none());
        let beyond = Ray { t_min: 0.61, ..Ray::new(DVec3::splat(0.4), DVec3::X) };
        assert!(cube.hit(&beyond).is_none() && !cube.blocked(&beyond));
        assert!(cube.hit(&Ray::new(DVec3::splat(2.0), DVec3::X)).is_none());
    }

    #[test]
    fn tree_equals_brute_force_on_triangle_soup() {
        let mut stream = numbers();
        for size in [1.0, 0.2, 0.01] {
            let positions: Vec<_> = (0..200)
                .flat_map(|_| {
                    let at = point(&mut stream);
                    [0, 1, 2].map(|_| at + size * (point(&mut stream) - 0.5))
                })
                .collect();
            let triangles = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let mesh = Mesh::new(positions, triangles).expect("indices in range");
            let soup = MeshSurface::new(mesh).expect("a surface");
            for i in 0..3000 {
                let d = direction(&mut stream);
                let distance = [0.0, 1.0, 1e3, 1e6, 1e10][i % 5];
                let ray = Ray::new(point(&mut stream) - distance * d, d);
                let ray = if i % 2 == 0 { ray } else { ray.up_to(distance + 0.3) };
                let hit = soup.hit(&ray).map(|h| h.distance);
                assert_eq!(hit, brute_force(&soup, &ray), "{ray:?}");
                assert_eq!(soup.blocked(&ray), hit.is_some());
            }
        }
    }

    fn bumpy() -> MeshSurface {
        let sphere = shapes::sphere(4);
        let bump = |p: &DVec3| *p * (1.0 + 0.2 * (5.0 * p.x).sin() * (4.0 * p.y).cos());
        let positions = sphere.positions().iter().map(bump).collect();
        let mesh = Mesh::new(positions, sphere.triangles().to_vec()).expect("indices in range");
        MeshSurface::smooth(mesh).expect("a surface")
    }

    fn chords(count: usize) -> Vec<Ray> {
        let mut stream = numbers();
        let mut chord = |i: usize| {
            let [from, to] = [0, 1].map(|_| 1.5 * direction(&mut stream));
            let ray = Ray::new(from, (to - from).normalize());
            if i.is_multiple_of(3) { ray.up_to(1.0) } else { ray }
        };
        (0..count).map(&mut chord).collect()
    }

    #[test]
    fn batches_equal_single_queries_to_the_bit() {
        let (surface, rays) = (bumpy(), chords(2000));
        let mut hits = vec![None; rays.len()];
        surface.hits(&rays, &mut hits);
        // Every seventh is marked already and stays so.
        let mut marked: Vec<_> = (0..rays.len()).map(|i| i.is_multiple_of(7)).collect();
        surface.mark_blocked(&rays, &mut marked);
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(hits[i], surface.hit(ray));
            assert_eq!(surface.blocked(ray), hits[i].is_some());
            assert_eq!(marked[i], i.is_multiple_of(7) || hits[i].is_some());
        }
    }

    #[test]
    fn instruction_sets_agree_within_the_bound() {
        let rays = chords(2000);
        let widest = bumpy();
        let narrow = MeshSurface { level: Level::baseline(), ..widest.clone() };
        let mut met = 0;
        for ray in &rays {
            let (a, b) = (widest.hit(ray), narrow.hit(ray));
            // A fused product moves the ray by a rounding of its distances, 2 metres at most; faces
            // are seen at 1e-2 or steeper.
            let along = 1e2 * 2.0 * f64::EPSILON;
            let agree = match (a, b) {
                (Some(a), Some(b)) => {
                    met += 1;
                    (a.point - b.point).length() <= a.error + b.error + along
                        && (a.distance - b.distance).abs() <= a.error + b.error + along
                }
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(agree, "{ray:?} {a:?} {b:?}");
        }
        assert!(met > 500);
    }

    #[test]
    fn rays_in_the_planes_of_faces_agree_with_brute_force() {
        let cube = MeshSurface::new(shapes::cube()).expect("a surface");
        let axes = [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.0, 0.6, -0.8)];
        for d in axes {
            for i in 0..27 {
                let through =
                    0.5 * DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9));
                for distance in [0.0, 3.0, 3e6] {
                    let ray = Ray::new(through - distance * d, d);
                    let hit = cube.hit(&ray).map(|h| h.distance);
                    assert_eq!(hit, brute_force(&cube, &ray), "{ray:?}");
                }
            }
        }
    }

    #[test]
    fn no_ray_slips_through_vertices_and_edges() {
        let mut stream = numbers();
        let meshes = [
            shapes::cube().translated(DVec3::splat(-0.5)),
            shapes::sphere(3),
            shapes::sphere(2).translated(DVec3::new(0.1, -0.2, 0.3)),
        ];
        for mesh in meshes {
            let surface = MeshSurface::new(mesh).expect("a surface");
            for face in 0..surface.mesh.triangles().len() {
                let [a, b, c] = surface.mesh.corners(face);
                let [s, t] = stream.next_2d();
                // From inside through a vertex, a middle of an edge and any point of it.
                for target in [a, 0.5 * (a + b), a + s * (b - a), b + t * (c - b)] {
                    let from = 0.1 * (point(&mut stream) - 0.5);
                    for origin in [DVec3::ZERO, from] {
                        let out = Ray::new(origin, (target - origin).normalize());
                        assert!(surface.hit(&out).is_some() && surface.blocked(&out), "{out:?}");
                        // And from far outside towards the inside: through both walls.
                        for distance in [2.0, 1e3, 1e6] {
                            let back = Ray::new(target + distance * out.direction, -out.direction);
                            let hit = surface.hit(&back);
                            let near = hit.is_some_and(|h| h.distance <= distance + 1e-6);
                            assert!(near, "{back:?} {hit:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn error_bounds_the_distance_from_the_plane() {
        // Thin, large and far triangles; the plane is evaluated in twice the precision by splitting
        // the dot product.
        let mut stream = numbers();
        for i in 0..3000 {
            let offset = [0.0, 1.0, 1e4, 1e8][i % 4] * (point(&mut stream) - 0.5);
            let thin = [1.0, 1e-3, 1e-7][i % 3];
            let a = offset + point(&mut stream);
            let (b, c) = (a + point(&mut stream), a + thin * point(&mut stream));
            let mesh = Mesh::new(vec![a, b, c], vec![[0, 1, 2]]).expect("indices in range");
            let Ok(surface) = MeshSurface::new(mesh) else { continue };
            let sample = surface.sample_area(DVec2::from(stream.next_2d()));
            let ray = Ray::between(offset + point(&mut stream) * 3.0, sample.hit.point);
            for hit in ray
                .and_then(|r| surface.hit(&Ray { t_max: f64::INFINITY, ..r }))
                .into_iter()
                .chain([sample.hit])
            {
                // Both differences are exact to u of the coordinates at most, which the bound
                // exceeds many times.
                let off = (hit.point - a).dot((b - a).cross(c - a).normalize());
                let slack = 4.0
                    * f64::EPSILON
                    * (hit.point - a).length()
                    * (b - a).length()
                    * (c - a).length()
                    / (b - a).cross(c - a).length();
                assert!(off.abs() <= hit.error + slack, "{off} {} {slack}", hit.error);
            }
        }
    }

    #[test]
    fn leaving_rays_never_meet_the_face_they_leave() {
        let mut stream = numbers();
        let meshes = [
            shapes::sphere(2).translated(DVec3::splat(30.0)),
            shapes::sphere(0),
            shapes::cube(),
            // Faces in the planes of the axes, edges short against some coordinates and long
            // against others.
            shapes::cube().scaled(1e-3).expect("positive").translated(DVec3::new(5.0, 0.0, -1e-3)),
            shapes::cube().scaled(1e5).expect("positive"),
        ];
        for mesh in meshes {
            let surface = MeshSurface::new(mesh).expect("a surface");
            for i in 0..5000 {
                let hit = surface.sample_area(DVec2::from(stream.next_2d())).hit;
                // From steep to grazing: down to 1e-9 radians above the plane.
                let frame = crate::math::Frame::about(hit.normal);
                let along = frame
                    .to_world(sampling::uniform_sphere(stream.next_2d()).with_z(0.0).normalize());
                let rise = 10.0_f64.powi(-(i % 10)) * stream.next_2d()[0];
                let out = hit.leave((along + rise * hit.normal).normalize());
                assert!(surface.hit(&out).is_none(), "convex: {out:?}");
                let inward = hit.leave((along - rise * hit.normal).normalize());
                assert!(surface.hit(&inward).is_none_or(|h| h.part != hit.part), "{inward:?}");
            }
        }
    }

    #[test]
    fn smooth_normals_are_those_of_the_sphere() {
        let smooth = MeshSurface::smooth(shapes::sphere(4)).expect("a surface");
        let (mut worst, mut flat) = (0.0_f64, 0.0_f64);
        let mut stream = numbers();
        for _ in 0..1000 {
            let d = direction(&mut stream);
            let hit = smooth.hit(&Ray::new(DVec3::ZERO, d)).expect("from inside");
            assert!((hit.shading_normal.length() - 1.0).abs() <= 1e-14);
            worst = worst.max(hit.shading_normal.angle_between(d));
            flat = flat.max(hit.normal.angle_between(d));
        }
        // Faces of about 0.1 radians: flat normals are off by up to that, interpolated ones by its
        // square.
        assert!(flat > 0.05 && worst <= 0.02, "{worst} {flat}");
    }

    #[test]
    fn area_samples_are_uniform_and_on_the_surface() {
        let l_shape = MeshSurface::new(shapes::l_shape()).expect("a surface");
        assert!((l_shape.area() - 22.0).abs() <= 1e-13);
        let n = 128;
        let (mut top, mut mean) = (0.0, DVec3::ZERO);
        for i in 0..n * n {
            let u = (DVec2::new(f64::from(i / n), f64::from(i % n)) + 0.5) / f64::from(n);
            let AreaPoint { hit, density } = l_shape.sample_area(u);
            assert_eq!((density, l_shape.density(&hit)), (1.0 / 22.0, 1.0 / 22.0));
            top += f64::from(u8::from(hit.normal.z > 0.5));
            mean += hit.point;
        }
        let n = f64::from(n * n);
        // A regular grid over 20 triangles: good to about one column of it.
        assert!((top / n - 5.0 / 22.0).abs() <= 1e-2);
        assert!((mean.z / n - 0.5).abs() <= 1e-2);
    }
}
