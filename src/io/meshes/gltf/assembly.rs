//! The default scene of a glTF file, node by node, as one mesh.

use std::collections::HashMap;

use glam::DMat4;

use super::buffers::Buffers;
use super::document::{Document, Primitive};
use super::{broken, item};
use crate::Result;
use crate::io::meshes::parts::Parts;
use crate::io::meshes::welding::Welding;
use crate::io::source::{Source, not_finite};

/// How many vertices and faces a scene may have for each byte of its files: a mesh may be used by
/// many nodes, and a small file must not become a mesh that fills the memory.
const REPEATS: u64 = 8;

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Gathers the mesh.
pub(super) struct Assembly<'a, 's> {
    source: &'a Source<'s>,
    document: &'a Document<'a>,
    buffers: &'a Buffers<'a>,
    parts: Parts,
    /// How many vertices and faces may still come.
    room: u64,
}

/// What the primitives of one node share.
#[derive(Default)]
struct Shared {
    welding: Welding,
    /// The vertices that the positions of an accessor have become.
    vertices: HashMap<usize, Vec<u32>>,
}

impl<'a, 's> Assembly<'a, 's> {
    /// Gathers the default scene; `bytes` is the size of all its files.
    pub(super) fn of(
        source: &'a Source<'s>,
        document: &'a Document<'a>,
        buffers: &'a Buffers<'a>,
        bytes: u64,
    ) -> Result<Parts> {
        let room = REPEATS.saturating_mul(bytes);
        let mut all = Self { source, document, buffers, parts: Parts::default(), room };
        let mut seen = vec![false; document.nodes.len()];
        let mut todo: Vec<(usize, DMat4)> =
            all.roots()?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
        while let Some((index, above)) = todo.pop() {
            let node = item(source, &document.nodes, index, "node")?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(broken(source, format!("node {index} is used twice")));
            }
            let transform = above * node.transform();
            if let Some(mesh) = node.mesh {
                // A skin places its vertices by its joints alone; at rest they stay where they are.
                all.add_mesh(mesh, if node.skin.is_some() { DMat4::IDENTITY } else { transform })?;
            }
            todo.extend(node.children.iter().rev().map(|&child| (child, transform)));
        }
        Ok(all.parts)
    }

    /// Lists the nodes the scene begins with; without scenes, those that are no child.
    fn roots(&self) -> Result<Vec<usize>> {
        if self.document.scenes.is_empty() {
            let mut is_child = vec![false; self.document.nodes.len()];
            for &child in self.document.nodes.iter().flat_map(|n| &n.children) {
                item(self.source, &self.document.nodes, child, "node")?;
                is_child[child] = true;
            }
            return Ok((0..is_child.len()).filter(|&n| !is_child[n]).collect());
        }
        let scene = self.document.scene.unwrap_or(0);
        Ok(item(self.source, &self.document.scenes, scene, "scene")?.nodes.clone())
    }

    fn add_mesh(&mut self, index: usize, transform: DMat4) -> Result<()> {
        let mesh = item(self.source, &self.document.meshes, index, "mesh")?;
        let mut shared = Shared::default();
        for primitive in &mesh.primitives {
            self.add_primitive(primitive, transform, &mut shared)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive,
        transform: DMat4,
        shared: &mut Shared,
    ) -> Result<()> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        let Some(accessor) = primitive.attributes.position.filter(|_| mode >= TRIANGLES) else {
            return Ok(());
        };
        if !shared.vertices.contains_key(&accessor) {
            let vertices = self.add_vertices(accessor, transform, &mut shared.welding)?;
            shared.vertices.insert(accessor, vertices);
        }
        let vertices = shared.vertices.get(&accessor).map_or(&[][..], Vec::as_slice);
        let corners = match primitive.indices {
            None => vertices.to_vec(),
            Some(indices) => self.named(indices, vertices)?,
        };
        self.take_room(corners.len())?;
        // A transform that mirrors turns the faces: the format wants them to look outwards still.
        let is_mirrored = transform.determinant() < 0.0;
        let triangle = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        self.parts.triangles.extend(self.cut(mode, &corners)?.map(triangle));
        Ok(())
    }

    /// Replaces indices by the vertices they name.
    fn named(&self, accessor: usize, vertices: &[u32]) -> Result<Vec<u32>> {
        let mut corners =
            self.buffers.indices(self.source, self.document, accessor, self.room / 4)?;
        for corner in &mut corners {
            *corner = *vertices.get(*corner as usize).ok_or_else(|| {
                let message = format!(
                    "accessor {accessor} names vertex {corner} of {} (from 0)",
                    vertices.len()
                );
                broken(self.source, message)
            })?;
        }
        Ok(corners)
    }

    /// Cuts the corners of a primitive into triangles.
    fn cut<'c>(
        &self,
        mode: u32,
        corners: &'c [u32],
    ) -> Result<Box<dyn Iterator<Item = [u32; 3]> + 'c>> {
        let windows = corners.windows(3).enumerate();
        match mode {
            TRIANGLES if !corners.len().is_multiple_of(3) => {
                Err(broken(self.source, format!("triangles of {} corners", corners.len())))
            }
            TRIANGLES => Ok(Box::new(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]))),
            // Every other triangle is turned; those that name a vertex twice only join one strip to
            // the next.
            STRIP => Ok(Box::new(windows.filter_map(|(i, w)| {
                let triangle = if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]).then_some(triangle)
            }))),
            FAN => Ok(Box::new(corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]))),
            _ => Err(broken(self.source, format!("primitives of the unknown mode {mode}"))),
        }
    }

    fn add_vertices(
        &mut self,
        accessor: usize,
        transform: DMat4,
        welding: &mut Welding,
    ) -> Result<Vec<u32>> {
        let positions =
            self.buffers.positions(self.source, self.document, accessor, self.room / 4)?;
        self.take_room(positions.len())?;
        let place = |(i, p)| {
            let position = transform.transform_point3(p);
            if !position.is_finite() {
                let (message, help) = not_finite(i, position);
                return Err(self.source.fault(format!("accessor {accessor}: {message}"), help));
            }
            welding.vertex(self.source, position, &mut self.parts)
        };
        positions.into_iter().enumerate().map(place).collect()
    }

    fn take_room(&mut self, count: usize) -> Result<()> {
        match self.room.checked_sub(count as u64) {
            Some(left) => {
                self.room = left;
                Ok(())
            }
            None => Err(self.source.fault(
                format!(
                    "the scene repeats its meshes to more than {REPEATS} vertices and faces \
                         for each byte of its files"
                ),
                "export it with fewer repetitions, or as PLY",
            )),
        }
    }
}
