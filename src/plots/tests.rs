use super::*;
use crate::io::output::{Kind, Output};

fn figure() -> Figure {
    let line =
        |k: f64| (1..=32).map(|l| [f64::from(l), k * f64::from(l).powi(-3)]).collect::<Vec<_>>();
    let errors = line(0.02).iter().map(|p| [0.3 * p[1], 0.5 * p[1]]).collect();
    let curves = vec![
        Curve::new("head", line(0.1)),
        Curve::new("rock & <stone>", line(0.02)).with_errors(errors).drawn(Style::Points),
        Curve::new("limit", line(0.5)).drawn(Style::Line),
    ];
    let axes = [Axis::logarithmic("degree l"), Axis::logarithmic("power, m\u{b2}")];
    Figure::new("Power per degree", axes, curves)
}

#[test]
fn nothing_to_show_is_refused() {
    let axes = || [Axis::linear("x"), Axis::logarithmic("y")];
    for points in [vec![], vec![[1.0, 0.0]], vec![[f64::NAN, 1.0], [2.0, f64::INFINITY]]] {
        let figure = Figure::new("Empty", axes(), vec![Curve::new("a", points)]);
        let message = figure.to_svg().expect_err("refused").to_string();
        assert!(message.contains("Empty: there is nothing to plot"), "{message}");
        assert!(figure.to_png().is_err() && figure.to_terminal(80, 24, true).is_err());
    }
}

#[test]
fn one_point_and_equal_points_are_drawn() {
    for scale in [Axis::linear("x"), Axis::logarithmic("x")] {
        for points in
            [vec![[1.0, 1.0]], vec![[2.0, 3.0]; 4], vec![[1e-300, 1e300], [1e300, 1e-300]]]
        {
            let figure =
                Figure::new("Few", [scale.clone(), scale.clone()], vec![Curve::new("a", points)]);
            assert!(figure.to_svg().expect("drawn").starts_with("<svg"));
            assert!(!figure.to_terminal(0, 0, false).expect("drawn").is_empty());
        }
    }
}

#[test]
fn svg_says_what_it_shows_and_is_well_formed() {
    let svg = figure().to_svg().expect("drawn");
    for words in
        ["Power per degree", "degree l", "power, m\u{b2}", "head", "rock &amp; &lt;stone&gt;"]
    {
        assert!(svg.contains(words), "{words}");
    }
    // Every element that is opened is closed.
    let opened = svg.matches('<').count() - svg.matches("</").count() - svg.matches("<!--").count();
    assert_eq!(opened, svg.matches("</").count() + svg.matches("/>").count());
}

#[test]
fn png_has_its_size_and_the_colours_of_the_curves() {
    let png = figure().to_png().expect("drawn");
    let image = image::load_from_memory(&png).expect("a PNG").into_rgb8();
    assert_eq!(image.dimensions(), (1720, 1120));
    assert_eq!(image[(2, 2)].0, [255; 3]);
    for colour in [[0x00, 0x72, 0xb2], [0xd5, 0x5e, 0x00], [0x00, 0x9e, 0x73]] {
        assert!(image.pixels().filter(|p| p.0 == colour).count() >= 20, "{colour:?}");
    }
}

#[test]
fn terminal_gets_its_size_and_no_escapes_unless_asked() {
    let text = figure().to_terminal(100, 30, false).expect("drawn");
    assert!(text.lines().count() <= 30 && text.lines().all(|l| l.chars().count() <= 100));
    assert!(text.contains("Power per degree") && text.contains("head") && !text.contains('\x1b'));
    assert!(figure().to_terminal(100, 30, true).expect("drawn").contains('\x1b'));
}

#[test]
fn files_are_known_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let files: [(&str, Kind, Vec<u8>); 2] = [
        ("plot.svg", Kind::SVG, figure().to_svg().expect("drawn").into_bytes()),
        ("plot.png", Kind::PNG, figure().to_png().expect("drawn")),
    ];
    for (name, kind, bytes) in files {
        let path = folder.path().join(name);
        for _ in 0..2 {
            Output::open_again(&path, &kind, false)
                .expect("free, then ours")
                .write(&bytes)
                .expect("written");
        }
    }
    let foreign = folder.path().join("drawing.svg");
    std::fs::write(&foreign, "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>").expect("written");
    assert!(Output::open_again(&foreign, &Kind::SVG, false).is_err());
}
