//! Files that other packages wrote, held to the radii that these packages compute from them;
//! tests/interop/ has the scripts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use harmolux::fit::Shape;
use harmolux::io::coefficients;
use harmolux::io::coefficients::{ReadOptions, SeriesFormat, Tolerance, WriteOptions, encode};
use harmolux::sh::{CondonShortley, Convention, Normalisation, Series};

const MM: f64 = 1e-3;

/// What the packages' roundings may make of a radius: pyshtools takes the sine from the cosine,
/// which a thousandth of a degree beside the pole leaves seven digits.
const ROUNDING: f64 = 1e-12;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/interop")
}

fn convention(normalisation: Normalisation, phase: CondonShortley) -> ReadOptions {
    let convention = Some(Convention { normalisation, phase });
    ReadOptions { convention, ..ReadOptions::default() }
}

fn read(name: &str, options: &ReadOptions) -> Shape {
    coefficients::read(&folder().join(name), options).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the radii that are known of a file: direction and value.
fn known(name: &str) -> Vec<(DVec3, f64)> {
    let text = std::fs::read_to_string(folder().join("radii.json")).expect("readable");
    let all: BTreeMap<String, Vec<[f64; 3]>> = serde_json::from_str(&text).expect("JSON");
    let direction = |latitude: f64, longitude: f64| {
        let ((s, c), (sin, cos)) =
            (latitude.to_radians().sin_cos(), longitude.to_radians().sin_cos());
        DVec3::new(c * cos, c * sin, s)
    };
    all[name].iter().map(|[lat, lon, r]| (direction(*lat, *lon), *r)).collect()
}

/// Holds a shape to the known radii of a file.
fn assert_radii(shape: &Shape, name: &str, tolerance: f64) {
    let series = Series::new(&shape.coefficients).expect("evaluable");
    let known = known(name);
    assert!(known.len() >= 4);
    for (omega, radius) in known {
        let found = series.value(omega);
        let error = (found / radius - 1.0).abs();
        assert!(error <= tolerance, "{name}, {omega}: {found} instead of {radius}, {error:e}");
    }
}

#[test]
fn files_of_pyshtools_in_all_normalisations() {
    for (name, normalisation, phase) in [
        ("pyshtools_ortho.sh", Normalisation::Orthonormal, CondonShortley::With),
        ("pyshtools_schmidt.dov", Normalisation::Schmidt, CondonShortley::Without),
        ("pyshtools_unnorm.bshc", Normalisation::Unnormalised, CondonShortley::Without),
        ("pyshtools_4pi.npy", Normalisation::FourPi, CondonShortley::With),
    ] {
        let shape = read(name, &convention(normalisation, phase));
        assert_eq!(shape.coefficients.lmax(), 12);
        assert_radii(&shape, name, ROUNDING);
        let error = coefficients::read(&folder().join(name), &ReadOptions::default());
        let message = error.expect_err("no convention").to_string();
        assert!(message.contains("the file does not say how it is normalised"), "{message}");
    }
}

#[test]
fn a_lm_of_healpy_and_ducc0() {
    let options = ReadOptions::default();
    assert_radii(&read("ducc0_alm.npy", &options), "ducc0_alm.npy", ROUNDING);
    assert_radii(&read("healpy_alm.npy", &options), "healpy_alm.npy", ROUNDING);
}

#[test]
fn set_of_spharm_pdm_with_its_six_decimals() {
    let options = ReadOptions { unit: Some(MM), ..ReadOptions::default() };
    let shape = read("spharm_pdm_mm.coef", &options);
    assert_eq!(shape.coefficients.lmax(), 12);
    // Half a micrometre of the millimetre's sixth decimal is 5e-10 m: some 200 of them, by 0.08 m.
    assert_radii(&shape, "spharm_pdm_mm.coef", 1e-7);
    assert!(shape.centre.distance(DVec3::new(0.01, -0.02, 0.03)) <= 1e-9, "{}", shape.centre);
}

#[test]
fn table_of_aics_shparam_row_by_row() {
    for row in [1, 2] {
        let options = ReadOptions { row: Some(row), ..ReadOptions::default() };
        let shape = read("aicsshparam.csv", &options);
        assert_eq!(shape.coefficients.lmax(), 8);
        assert_radii(&shape, &format!("aicsshparam.csv:{row}"), ROUNDING);
        // The pears reach from 3.5 to 43.5 voxels and are thick towards +x, their centroids at
        // 26.1: 22.6 voxels one way, 17.4 the other.
        let f = Series::new(&shape.coefficients).expect("evaluable");
        assert!(f.value(DVec3::NEG_X) > f.value(DVec3::X) + 2.0);
    }
}

#[test]
fn record_of_the_planetary_data_system() {
    let options = ReadOptions { unit: Some(1000.0), ..ReadOptions::default() };
    assert_radii(&read("shadr_km.tab", &options), "shadr_km.tab", ROUNDING);
}

#[test]
fn every_format_brings_back_what_every_other_keeps() {
    let start = read("ducc0_alm.npy", &ReadOptions::default());
    for format in SeriesFormat::ALL.into_iter().filter(|format| format.is_written()) {
        let bytes = encode(
            &start,
            format,
            &WriteOptions { tolerance: Tolerance::OfMeanRadius(1e-13), ..Default::default() },
        )
        .expect("fits every format");
        let options = ReadOptions { format: Some(format), ..Default::default() };
        let options = match format {
            SeriesFormat::Bshc | SeriesFormat::Npy => {
                ReadOptions { convention: Some(Convention::default()), ..options }
            }
            _ => options,
        };
        let back = coefficients::parse(Path::new("a"), &bytes, &options).expect("read again");
        assert_radii(&back, "ducc0_alm.npy", ROUNDING);
    }
}

/// Cuts, and bytes turned over, in every fixture: an error or a shape, never a panic.
#[test]
fn non_finite_files_end_in_an_error_or_a_shape() {
    let entries = std::fs::read_dir(folder()).expect("readable");
    let options = convention(Normalisation::FourPi, CondonShortley::Without);
    for path in entries.map(|e| e.expect("readable").path()) {
        let bytes = std::fs::read(&path).expect("readable");
        for i in 0..200 {
            let at = i * bytes.len() / 200;
            let cut = coefficients::parse(&path, &bytes[..at], &options);
            assert!(cut.is_err() || path.extension().is_some_and(|e| e != "bshc" && e != "npy"));
            let mut turned = bytes.clone();
            turned[at] ^= 1 << (i % 8);
            let _ = coefficients::parse(&path, &turned, &options);
        }
    }
}
