//! What a shape and its mesh take as files: measured by writing them.

use super::row::{Column, SweepRow};
use crate::Result;
use crate::fit::Shape;
use crate::io::coefficients::{SeriesFormat, Tolerance, WriteOptions, encode};
use crate::io::meshes::{self, MeshFormat};
use crate::mesh::Mesh;
use crate::sh::places;

/// The part of its error to which a shape is compressed.
pub(super) const PART: f64 = 0.2;

/// Writes a series in every form; the compact one to a fifth of `rms`, metres, which is 0 for the
/// original: then it has none.
pub(super) fn series(row: &mut SweepRow, shape: &Shape, rms: f64) -> Result<()> {
    let size = |format, tolerance| -> Result<f64> {
        let options = WriteOptions { tolerance, ..WriteOptions::default() };
        Ok(encode(shape, format, &options)?.len() as f64)
    };
    let exact = WriteOptions::default().tolerance;
    row[Column::Numbers] = shape.coefficients.count() as f64;
    row[Column::BytesF64] = size(SeriesFormat::Binary, exact)?;
    row[Column::BytesF32] = numbers_in_f32(shape).len() as f64;
    row[Column::BytesText] = size(SeriesFormat::Text, exact)?;
    if rms > 0.0 {
        row[Column::BytesCompact] = size(SeriesFormat::Compact, Tolerance::Metres(PART * rms))?;
    }
    Ok(())
}

/// Writes the coefficients as f32, little endian: for each degree A_l0, A_l1, B_l1, ...
pub(in crate::study) fn numbers_in_f32(shape: &Shape) -> Vec<u8> {
    let series = &shape.coefficients;
    let number = |(l, m, sine)| {
        let (a, b) = series.get(l, m);
        if sine { b } else { a }
    };
    places(series.lmax()).map(number).flat_map(|x| (x as f32).to_le_bytes()).collect()
}

/// Writes a mesh in every form.
pub(super) fn mesh(row: &mut SweepRow, mesh: &Mesh) -> Result<()> {
    let size = |format| -> Result<f64> { Ok(meshes::encode(mesh, format)?.len() as f64) };
    row[Column::Numbers] = mesh.used_size()[0] as f64;
    row[Column::BytesF64] = indexed(mesh, f64::to_le_bytes).len() as f64;
    row[Column::BytesF32] = indexed(mesh, |x| (x as f32).to_le_bytes()).len() as f64;
    row[Column::BytesText] = size(MeshFormat::Obj)?;
    row[Column::BytesStl] = size(MeshFormat::Stl)?;
    row[Column::BytesPly] = size(MeshFormat::Ply)?;
    Ok(())
}

/// Writes vertices, and three indices a face: of two bytes where these reach all vertices.
fn indexed<const N: usize>(mesh: &Mesh, number: impl Fn(f64) -> [u8; N]) -> Vec<u8> {
    let mut places = vec![u32::MAX; mesh.positions().len()];
    let mut bytes = Vec::new();
    let mut count = 0;
    for vertex in mesh.triangles().as_flattened() {
        let place = &mut places[*vertex as usize];
        if *place == u32::MAX {
            *place = count;
            count += 1;
            bytes.extend(
                mesh.positions()[*vertex as usize].to_array().into_iter().flat_map(&number),
            );
        }
    }
    let indices = mesh.triangles().as_flattened().iter().map(|vertex| places[*vertex as usize]);
    if count <= 1 << 16 {
        bytes.extend(indices.flat_map(|place| (place as u16).to_le_bytes()));
    } else {
        bytes.extend(indices.flat_map(u32::to_le_bytes));
    }
    bytes
}

/// Returns how many vertices a closed mesh without holes has that takes at most so many bytes in
/// f32: 12 for each vertex, and three indices for each of nearly two faces a vertex.
pub(super) fn vertices_for(bytes: usize) -> usize {
    // V vertices have 2V - 4 faces.
    let short = (bytes + 24) / 24;
    short.min(1 << 16).max((bytes + 48) / 36)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::sh::Coefficients;

    #[test]
    fn every_form_has_its_bytes() -> Result<()> {
        let mut row = SweepRow::new(super::super::Rendition::Original, None);
        mesh(&mut row, &shapes::cube())?;
        assert_eq!(row[Column::BytesF32], 8.0 * 12.0 + 12.0 * 6.0);
        assert_eq!(row[Column::BytesF64], 8.0 * 24.0 + 12.0 * 6.0);
        assert_eq!(row[Column::BytesStl], 84.0 + 12.0 * 50.0);
        assert_eq!(vertices_for(8 * 12 + 12 * 6), 8);
        let mut ball = Coefficients::zeros(3);
        ball.set(0, 0, 1.0, 0.0);
        let ball = Shape::new(ball);
        series(&mut row, &ball, 0.0)?;
        assert_eq!(row[Column::BytesF32], 64.0);
        Ok(())
    }
}
