//! The head of 32 654 faces in 32 spherical harmonics.

use harmolux::Result;
use harmolux::fit::{FitSettings, fit};

use super::{Claim, DEGREE, Run, Table, Verdict, grouped, percent};

const FACES: usize = 32_654;
/// Up to which RMS error a series counts as the head.
const FAITHFUL: f64 = 0.01;
/// The highest degree with at most 32 coefficients.
const LITERAL: usize = 4;

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let faces = run.head.mesh_size[1];
    let literal = fit(&run.mesh, &FitSettings::of_degree(LITERAL))?;
    let (degrees, literally) = (run.head.relative_rms(), literal.relative_rms());
    let row = |lmax: usize, rms: f64, max: f64| {
        let count = (lmax + 1) * (lmax + 1);
        vec![lmax.to_string(), count.to_string(), percent(rms, 3), percent(max, 3)]
    };
    Ok(vec![Claim {
        title: "A head of 32 654 faces in 32 harmonics",
        paper_words: "The head was given as a mesh of 32 654 faces. In the scene it was turned \
                      into 32 spherical harmonics.",
        place: "Implementation, Figure 3",
        paper_number: "32 654 faces, 32 harmonics".to_owned(),
        ours: format!(
            "{} faces, degrees 0 to {DEGREE}: {} coefficients",
            grouped(faces),
            run.head.coefficients.count()
        ),
        error: format!(
            "RMS {} of the mean radius, largest {}",
            percent(degrees, 3),
            percent(run.head.relative_max(), 3)
        ),
        command: "harmolux fit data/head.obj -l 32 -o head.txt".to_owned(),
        verdict: Verdict::of_printed(
            faces == FACES && literally <= FAITHFUL,
            faces == FACES && degrees <= FAITHFUL,
        ),
        notes: vec![
            format!(
                "Correction: 32 is the highest degree. As the number of coefficients it means \
                 degree {LITERAL}. A series counts as the head up to an RMS error of {}.",
                percent(FAITHFUL, 1)
            ),
            "The paper's head is not published; ours is another of the same size \
             (data/README.md)."
                .to_owned(),
        ],
        table: Some(Table {
            head: vec!["degree", "coefficients", "RMS error", "largest error"],
            rows: vec![
                row(LITERAL, literally, literal.relative_max()),
                row(DEGREE, degrees, run.head.relative_max()),
            ],
        }),
        picture: None,
    }])
}
