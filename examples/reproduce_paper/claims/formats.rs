//! The storage of the head: bytes of the mesh over bytes of its series, format by format.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use harmolux::fit::{Shape, Source, mesh_bytes, series_bytes};
use harmolux::io::coefficients::compact::{self, Tolerance};
use harmolux::io::coefficients::{binary, shtools_text};
use harmolux::io::meshes::{MeshFormat, encode};
use harmolux::sh::Convention;
use harmolux::{Error, Result};

use super::{Claim, Run, Table, Verdict, data, digits, grouped};

const CLAIMED: f64 = 1000.0;

/// Names a form and its bytes.
type Form = (&'static str, usize);

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let (meshes, series) = (meshes(run)?, series(run)?);
    let ratio = |mesh: Form, series: Form| mesh.1 as f64 / series.1 as f64;
    let all = || meshes.iter().flat_map(|m| series.iter().map(|s| ratio(*m, *s)));
    let likes = [(0, 0), (1, 1), (2, 2), (4, 3), (5, 4)];
    let likes = likes.map(|(m, s)| (m, s, ratio(meshes[m], series[s])));
    let range = [largest_of(likes, f64::min), largest_of(likes, f64::max)];
    let any = all().any(|r| r > CLAIMED);
    let row = |mesh: &Form| {
        let ratios = series.iter().map(|s| digits(ratio(*mesh, *s), 3));
        [mesh.0.to_owned(), grouped(mesh.1)].into_iter().chain(ratios).collect()
    };
    let bytes = series.iter().map(|s| grouped(s.1));
    let bytes = ["bytes".to_owned(), String::new()].into_iter().chain(bytes).collect();
    let like = |(m, s, r): &(usize, usize, f64)| {
        format!("{} over {} {}", meshes[*m].0, series[*s].0, digits(*r, 3))
    };
    Ok(vec![Claim {
        title: "1000 times less storage",
        paper_words: "The amount of stored information fell by more than 1000 times.",
        place: "Implementation, Figure 3",
        paper_number: "> 1000".to_owned(),
        ours: format!("{} to {}, like with like", digits(range[0], 3), digits(range[1], 3)),
        error: "none: bytes, counted".to_owned(),
        command: "cargo run --release --features experiments --example storage -- data/head.obj"
            .to_owned(),
        // Every pair of like forms must keep it, or any pair at all must for the direction.
        verdict: Verdict::of_number([CLAIMED, f64::INFINITY], [range[0]; 2], any),
        notes: vec![
            format!("Like with like: {}.", likes.iter().map(like).collect::<Vec<_>>().join("; ")),
            format!(
                "{} of all {} pairs exceed 1000. Like with like all must for the claim to hold. \
                 The compact form adds an RMS error of a fifth of the truncation error.",
                all().filter(|r| *r > CLAIMED).count(),
                all().count()
            ),
        ],
        table: Some(Table {
            head: ["mesh", "bytes"].into_iter().chain(series.iter().map(|s| s.0)).collect(),
            rows: [bytes].into_iter().chain(meshes.iter().map(row)).collect(),
        }),
        picture: None,
    }])
}

fn largest_of<const N: usize>(likes: [(usize, usize, f64); N], pick: fn(f64, f64) -> f64) -> f64 {
    likes.iter().map(|(_, _, ratio)| *ratio).reduce(pick).unwrap_or(f64::NAN)
}

fn meshes(run: &Run) -> Result<[Form; 6]> {
    let [vertices, faces] = run.head.mesh_size;
    let ply = encode(&run.mesh, MeshFormat::Ply)?;
    Ok([
        ("indexed f32", mesh_bytes([vertices, faces])),
        ("indexed f64", 24 * vertices + 12 * faces),
        ("OBJ", encode(&run.mesh, MeshFormat::Obj)?.len()),
        ("STL, binary", encode(&run.mesh, MeshFormat::Stl)?.len()),
        ("PLY, binary", ply.len()),
        ("PLY, gzip", zipped(&ply)?),
    ])
}

fn series(run: &Run) -> Result<[Form; 5]> {
    let fit = &run.head;
    let path = data("head.obj");
    let bytes = std::fs::read(&path).map_err(|e| Error::Parameter(format!("head.obj: {e}")))?;
    // As the tool writes it, with name and fingerprint of the mesh.
    let source = Some(Source::new(&path, &bytes));
    let shape = Shape { centre: fit.centre, source, ..Shape::new(fit.coefficients.clone()) };
    let text = shtools_text::write(&shape, Convention::default())?;
    Ok([
        ("f32", series_bytes(fit.coefficients.lmax())),
        ("f64", 8 * fit.coefficients.count()),
        ("text", text.len()),
        (".hxb", binary::encode(&shape)?.len()),
        (".hxc", compact::encode(&shape, Tolerance::Metres(fit.error.rms / 5.0))?.bytes.len()),
    ])
}

fn zipped(bytes: &[u8]) -> Result<usize> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    Ok(packed.map_err(|error| Error::Numeric(format!("gzip: {error}")))?.len())
}
