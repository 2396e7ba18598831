//! Problems whose answer is known, as a user meets them: `exact`.

use serde_json::Value;

use crate::common::desk::{Desk, Said, assert_says};

fn desk() -> Desk {
    Desk::of(&["exact"])
}

/// Runs a problem, which must succeed; gives what it prints.
fn said(arguments: &str) -> Said {
    desk().done(arguments)
}

/// Runs a problem and reads the JSON it prints.
fn json(arguments: &str) -> Value {
    desk().json(arguments)
}

fn rows(arguments: &str) -> Vec<Value> {
    json(arguments)["rows"].as_array().expect("rows").clone()
}

/// Returns a column of a problem.
fn column(arguments: &str, name: &str) -> Vec<f64> {
    rows(arguments).iter().map(|row| row[name].as_f64().expect("a number")).collect()
}

/// Holds a column to printed values.
fn compare(arguments: &str, name: &str, printed: &[f64], tolerance: f64) {
    let found = column(arguments, name);
    assert_eq!(found.len(), printed.len(), "{arguments}: {found:?}");
    for (value, expected) in found.iter().zip(printed) {
        assert!((value - expected).abs() <= tolerance, "{arguments}: {value} for {expected}");
    }
}

/// Every problem with its standard case, and the number of its rows.
const STANDARD: [(&str, usize); 19] = [
    ("sobolev", 10),
    ("sphere", 3),
    ("cap", 2),
    ("concentric", 2),
    ("planes", 2),
    ("room", 1),
    ("cube", 7),
    ("form-factor opposed", 1),
    ("form-factor perpendicular", 2),
    ("form-factor discs", 2),
    ("form-factor point", 2),
    ("form-factor polygon", 1),
    ("cie171-5.2", 10),
    ("cie171-5.3", 14),
    ("cie171-5.4", 7),
    ("cie171-5.5", 16),
    ("cie171-5.6", 13),
    ("cie171-5.7", 11),
    ("cie171-5.8", 14),
];

#[test]
fn standard_cases_need_no_options() {
    for (problem, count) in STANDARD {
        let table = said(problem).out;
        // A header and a rule above the rows.
        assert_eq!(table.lines().count(), count + 2, "{table}");
        assert!(table.lines().all(|line| line.starts_with('|') && line.ends_with('|')), "{table}");
        assert_eq!(rows(problem).len(), count, "{problem}");
    }
}

#[test]
fn csv_has_the_numbers_of_json_and_is_replaced_only_by_force() {
    for (problem, count) in STANDARD {
        let desk = desk();
        for _ in 0..2 {
            let said = desk.done(format!("{problem} -o out.csv --force"));
            assert!(said.err.contains("written out.csv"));
        }
        let csv = desk.text("out.csv");
        assert_eq!(csv.lines().count(), count + 1, "{csv}");
        let header: Vec<&str> = csv.lines().next().expect("a header").split(',').collect();
        for (line, row) in csv.lines().skip(1).zip(rows(problem)) {
            for (name, field) in header.iter().zip(line.split(',')) {
                match row[name].as_f64() {
                    // Both are written to the last bit, but serde_json reads fast, to within a unit
                    // in the last place.
                    Some(number) => {
                        let written: f64 = field.parse().expect("a number");
                        let error = (written - number).abs();
                        assert!(error <= f64::EPSILON * written.abs(), "{problem}: {name}");
                    }
                    None => assert_eq!(row[name], field, "{problem}: {name}"),
                }
            }
        }
    }
    let desk = desk().with("out.csv", "a poem");
    desk.refused("cap -o out.csv", &["--force"]);
    desk.done("cap -o out.csv --force");
}

#[test]
fn sobolev_planes_are_the_printed_tables() {
    let a = [
        4.528_129_525_817,
        3.367_492_450_477,
        1.860_290_080_710,
        0.653_442_317_194,
        0.306_312_045_082,
        0.166_497_749_941,
        0.062_150_240_621,
        0.028_066_583_982,
        0.014_392_632_466,
        0.001_509_430_494,
    ];
    // Printed to twelve decimals.
    compare("sobolev", "illuminance_lx", &a, 1e-12);
    compare("sobolev --plane upper", "illuminance_lx", &a, 1e-12);
    let b = "sobolev --reflectance 0.8,0.3 --height 0.7 --plane both -r 0,1";
    let printed = [2.472_169_062_193, 0.597_786_635_546, 11.745_207_517_055, 0.649_601_635_131];
    compare(b, "illuminance_lx", &printed, 1e-12);
    let light = printed.iter().zip([0.8, 0.8, 0.3, 0.3]);
    let luminance: Vec<f64> = light.map(|(e, rho)| rho * e / std::f64::consts::PI).collect();
    compare(b, "luminance_cd_m2", &luminance, 1e-12);
}

#[test]
fn sobolev_scales_with_gap_and_source() {
    // Twice as large with 4 cd, that is 16 pi lm: the same lux at twice the distance.
    let large = "sobolev --gap 2 --height 1 -r 0,2 --flux 50.26548245743669";
    compare(large, "illuminance_lx", &[4.528_129_525_817, 0.653_442_317_194], 1e-12);
}

#[test]
fn sobolev_orders_are_the_printed_series() {
    let row = &rows("sobolev --orders 6 -r 1")[0];
    let printed = [
        0.357_770_876,
        0.190_058_686,
        0.066_525_063,
        0.023_888_159,
        0.009_052_821,
        0.003_585_912,
        0.001_469_242,
    ];
    for (order, value) in printed.iter().enumerate() {
        let found = row[format!("order_{order}_lx")].as_f64().expect("a number");
        // Printed to nine decimals.
        assert!((found - value).abs() <= 5.1e-10, "{order}: {found}");
    }
}

#[test]
fn sobolev_discs_tell_what_escapes() {
    let discs = "sobolev --radius 2 -r 0,0.5,1,2";
    let printed = [4.514_082_781_9, 1.845_390_249_1, 0.635_696_282_9, 0.136_426_001_1];
    // Printed to ten decimals.
    compare(discs, "illuminance_lx", &printed, 6e-11);
    let report = json(discs);
    let [escaped, flux] =
        ["escaped_flux_lm", "source_flux_lm"].map(|key| report[key].as_f64().expect("a number"));
    assert!((flux - 4.0 * std::f64::consts::PI).abs() <= 1e-14 && escaped < 0.5 * flux);
    assert!(said(discs).err.contains("of 12.5664 lm from the source 5.18"));
    // Black surroundings receive and send nothing back.
    let row = &rows("sobolev --radius 2 -r 3")[0];
    assert_eq!(row["luminance_cd_m2"], 0.0);
    assert!(row["illuminance_lx"].as_f64() > Some(0.03));
}

#[test]
fn enclosures_are_the_printed_values() {
    let sphere = [0.464_367_188_880_856_4, 0.202_998_306_170_439_82, 0.181_425_067_828_597_96];
    compare("sphere", "illuminance_lx", &sphere, 1e-15);
    compare("sphere", "indirect_lx", &[0.146_057_302_697_065_66; 3], 1e-15);
    compare("sphere --at -1", "illuminance_lx", &sphere[2..], 1e-15);
    compare("cap", "exitance_lm_m2", &[5.0 / 6.0, 1.25], 1e-15);
    compare("cap", "illuminance_lx", &[25.0 / 24.0, 5.0 / 6.0], 1e-15);
    compare("concentric", "exitance_lm_m2", &[1.172_839_506_2, 0.432_098_765_4], 5.1e-11);
    compare("planes", "exitance_lm_m2", &[4.0 / 3.0, 2.0 / 3.0], 1e-15);
    compare("room --reflectance 0,0.5", "mean_illuminance_lx", &[625.0 / 6.0, 625.0 / 3.0], 1e-12);
}

#[test]
fn cube_is_the_printed_table() {
    let half = [310.981, 278.103, 253.230, 216.074, 161.07];
    // The table is good to 1e-5 inside.
    let found = column("cube", "illuminance_lx");
    for (value, expected) in found.iter().zip(half) {
        assert!((value / expected - 1.0).abs() <= 3e-5, "{value} for {expected}");
    }
    // The case is the same cube, and the report's formula the mean.
    assert_eq!(column("cie171-5.8 --reflectance 0.5", "illuminance_lx"), found);
    compare("cie171-5.8 --at 0,0", "published_indirect_lx", &[1250.0 / 12.0, 1250.0 / 3.0], 1e-10);
    // Half the size under the same lamp: four times the light, and the points move along.
    let small = column("cube --edge 2", "illuminance_lx");
    assert!(small.iter().zip(&found).all(|(s, f)| (s / f - 4.0).abs() <= 1e-12));
    assert_eq!(column("cube --edge 2 --at -0.25,0.25", "illuminance_lx").len(), 1);
}

#[test]
fn form_factors_are_the_printed_values() {
    let cases: [(&str, &[f64]); 6] = [
        ("opposed", &[0.199_824_895_7]),
        ("opposed --width 2", &[0.285_875_384_9]),
        ("opposed --width 4 --depth 4 --distance 3", &[0.282_732_787_4]),
        ("perpendicular --common 4 --from 4 --to 3", &[0.179_316_803_2, 0.239_089_070_9]),
        ("discs", &[0.381_966_011_3; 2]),
        // The way back by reciprocity: areas are 1 to 4.
        ("discs --from 0.5 --to 1 --distance 0.7", &[0.632_123_598_2, 0.158_030_899_55]),
    ];
    for (surfaces, printed) in cases {
        compare(&format!("form-factor {surfaces}"), "form_factor", printed, 5.1e-11);
    }
    let parallel = column("form-factor point", "configuration_factor")[0];
    compare("form-factor polygon", "configuration_factor", &[parallel], 1e-15);
    // Case 5.3 at its point A by the polygon of the source: E = 1000 pi C.
    let source = "--vertex 1.5,1.5,3 --vertex 2.5,1.5,3 --vertex 2.5,2.5,3 --vertex 1.5,2.5,3";
    let a = format!("form-factor polygon {source} --at 2,0,2.75 --normal 0,5,0");
    compare(&a, "illuminance_per_luminance_sr", &[0.032_676_9], 5.1e-8);
}

#[test]
fn cases_of_cie_171_are_the_printed_tables() {
    // Printed to four decimals.
    let cases: [(&str, &str, &[f64]); 4] = [
        (
            "cie171-5.2",
            "illuminance_lx",
            &[
                111.1111, 105.1863, 90.0, 71.1111, 99.7230, 85.6633, 68.0529, 74.3802, 59.9750,
                49.3827,
            ],
        ),
        (
            "cie171-5.3",
            "illuminance_lx",
            &[
                32.6769, 75.1939, 81.3232, 69.0606, 53.4035, 40.0019, 61.4241, 79.2552, 95.6673,
                105.7782, 105.7782, 95.6673, 79.2552, 61.4241,
            ],
        ),
        (
            "cie171-5.6",
            "ratio_percent",
            &[
                12.9674, 16.7163, 21.6385, 27.9916, 35.9005, 26.7952, 30.9387, 33.9757, 35.5666,
                35.5666, 33.9757, 30.9387, 26.7952,
            ],
        ),
        (
            "cie171-5.7",
            "ratio_percent",
            &[
                16.0706, 16.3297, 15.3988, 13.3220, 10.3169, 7.0790, 3.3823, 3.6290, 3.0130, 0.0,
                0.0,
            ],
        ),
    ];
    for (case, name, printed) in cases {
        compare(case, name, printed, 5.1e-5);
    }
    let a = &rows("cie171-5.3")[0];
    assert_eq!((&a["point"], &a["z_m"], &a["normal_y"]), (&"A".into(), &2.75.into(), &1.0.into()));
    assert_eq!(a["published_illuminance_lx"], 32.68);
    assert!(said("cie171-5.7").err.contains("Table 19"));
}

#[test]
fn flux_is_conserved_and_glass_is_the_printed_table() {
    for at in ["2,2,1.5", "0.5,3.9,2.9"] {
        let share = column(&format!("cie171-5.4 --at {at}"), "share");
        assert!((share[6] - 1.0).abs() <= 1e-14, "{share:?}");
    }
    let glass = "cie171-5.5 --angles 0,60,85";
    let printed = [0.918_318, 0.843_471, 0.245_646, 0.881_460, 0.801_519, 0.219_815];
    compare(glass, "transmittance", &printed, 5.1e-7);
}

#[test]
fn bad_input_is_refused_with_words() {
    for (code, arguments, words) in [
        (2, "", "PROBLEM"),
        (2, "nothing", "unrecognized subcommand"),
        (2, "form-factor", "SURFACES"),
        (2, "sobolev --reflectance 1,2,3", "one number for both"),
        (2, "sobolev --radius 2 --orders 2", "cannot be used with"),
        (2, "sobolev --orders 101", "0..=100"),
        (2, "sobolev -r 0,,1", "invalid value"),
        (2, "cube --at 1", "2 numbers"),
        (2, "cie171-5.5 --angles 91", "0 to 90"),
        (3, "sobolev --reflectance 1", "take finite discs"),
        (3, "sobolev --reflectance 1.5", "between 0 and 1"),
        (3, "sobolev --height 1", "between 0 and the gap"),
        (3, "sobolev -r nan", "the distance r is NaN"),
        (3, "sobolev --radius 51", "take infinite planes"),
        (3, "sphere --offset -1", "smaller than the radius"),
        (3, "sphere --at 1.5", "between -1 and 1"),
        (3, "cap --fraction 1", "between 0 and 1"),
        (3, "concentric --radius 2,1", "smaller than the outer one"),
        (3, "planes --reflectance 1", "lower one of them"),
        (3, "room --area 0", "the area"),
        (3, "cube --reflectance 1", "below 1"),
        (3, "cube --at 3,0", "within half an edge"),
        (3, "cie171-5.4 --at 0,2,1", "the source's x"),
        (3, "cie171-5.5 --internal 2", "the internal transmittance"),
        (3, "form-factor opposed --width 0", "above 0"),
        (3, "form-factor polygon --vertex 1,2,3", "three vertices or more, not 1"),
        (3, "form-factor polygon --normal 0,0,0", "no direction"),
        (3, "form-factor discs --from 1e-200 --to 1e200", "beyond the range of numbers"),
        (3, "cap -o out.txt", "name it out.csv"),
    ] {
        let said = desk().ends(code, arguments);
        assert_says(&said.err, &[words]);
        assert!(said.out.is_empty(), "{arguments}");
    }
}
