//! The reference of scene files, `docs/reference/scene.md`, is made from the code that reads them:
//! keys and their meaning from the structs, types from how they are read, examples from the help of
//! messages. After a change: `HARMOLUX_BLESS=1 cargo test --lib scene_reference`.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use super::super::suggest::example;
use super::super::types::{KINDS, types};
use super::super::values::{self, Range};
use super::super::{IllumEstimator, RenderEstimator};
use crate::math::{Choice, Unit};
use crate::mesh::UpAxis;
use crate::scene::{Filter, FisheyeMapping, Tone};
use crate::surface::Intersector;

/// The code that reads scenes.
const CODE: [&str; 8] = [
    include_str!("../material.rs"),
    include_str!("../object.rs"),
    include_str!("../placement.rs"),
    include_str!("../light.rs"),
    include_str!("../camera.rs"),
    include_str!("../sensor.rs"),
    include_str!("../surface_sensor.rs"),
    include_str!("../task.rs"),
];
const REQUIRE: &str = include_str!("../require.rs");

/// The enum of the types of a kind.
const ENUMS: [&str; 5] =
    ["MaterialSpec", "ObjectSpec", "WrittenLight", "CameraSpec", "WrittenSensor"];

const INTRODUCTION: &str = "\
# Scene files

<!-- Made from the code by `HARMOLUX_BLESS=1 cargo test --lib scene_reference`. -->

A scene is a TOML file. It begins with `format = 1`; every thing in it is `[kind.NAME.type]`, where
the name is yours. The whole path sets a value on the command line:
`-D lights.lamp.point.intensity=250`. Lengths are metres, z is up, angles are degrees. `2` and `2.0`
are the same; a point or a vector is `[x, y, z]`; a direction is a vector of any length above 0;
file paths start at the folder of the scene. A key that is not known is an error, with the nearest
one that is. `harmolux new` writes a scene to begin with, and [guides](../start.md) show whole ones.

A key without a default must be given, unless its text says otherwise.
";

/// A struct of keys.
struct Keys {
    about: String,
    fields: Vec<Field>,
}

/// A key: its name, how it is read, of which type, whether it may be left out, what it means.
struct Field {
    name: String,
    reader: String,
    r#type: String,
    default: Option<String>,
    meaning: String,
}

#[test]
fn scene_reference_is_that_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/scene.md");
    let now = reference();
    if std::env::var_os("HARMOLUX_BLESS").is_some() {
        std::fs::write(&path, &now).expect("written");
    }
    let stored = std::fs::read_to_string(&path).expect("docs/reference/scene.md");
    assert!(stored == now, "stale: HARMOLUX_BLESS=1 cargo test --lib scene_reference");
}

fn reference() -> String {
    let code = CODE.concat();
    let mut text = INTRODUCTION.to_owned();
    for (kind, of) in KINDS.into_iter().zip(ENUMS) {
        let _ = write!(text, "\n## {kind}\n");
        let variants = variants(&code, of);
        let names: Vec<String> = variants.iter().map(|v| v.0.to_lowercase()).collect();
        assert_eq!(names, types(kind), "{of} is the enum of {kind}");
        for (name, inner, about) in variants {
            let r#type = name.to_lowercase();
            section(&mut text, &format!("[{kind}.NAME.{type}]"), &about, kind, &inner);
        }
    }
    text.push_str("\n## Tables of one kind each\n");
    for (heading, about, name) in [
        ("[render]", "How a picture is made.", "RenderSpec"),
        ("[illum]", "How illuminance at the sensors is computed.", "IllumSpec"),
        (
            "stop",
            "Of `[render]` and `[illum]`: the first of these that is met ends the run.",
            "StopSpec",
        ),
        (
            "detail",
            "Of `[render]` and of `sh` objects: how far a picture may simplify shapes.",
            "DetailSpec",
        ),
        (
            "rotate",
            "Of objects from files: counter-clockwise about an axis through the origin of \
                    the file.",
            "Rotation",
        ),
    ] {
        let key = heading.trim_matches(['[', ']']);
        section(&mut text, heading, about, key, name);
    }
    let _ = write!(text, "\n{}", after(REQUIRE));
    text
}

/// Writes what `[require]` and `[compare]` take, whose keys are names of sensors.
fn after(code: &str) -> String {
    let mut text =
        "### `[require]`\n\nWhat the sensors of a group must show: `NAME = { key = value, \
                    ... }`, at least one key.\n\n| key | value | meaning |\n|---|---|---|\n"
            .to_owned();
    for field in keys(code, "RequireSpec").fields {
        let value = value_of(&field);
        let _ = writeln!(text, "| `{}` | {value} | {} |", field.name, field.meaning);
    }
    text.push_str(
        "\n```toml\n[require]\ndesk = { mean_min = 500, uniformity_min = 0.6 }\n```\n\n\
         ### `[compare]`\n\nWhat the sensors of a group are known to receive: `NAME = [lx, ...]`, \
         one for each in order, or the\nword of a problem with an exact solution that the scene \
         is:\n",
    );
    let words = super::super::ExactProblem::ALL.map(|problem| format!("`\"{}\"`", problem.name()));
    let _ = writeln!(text, "{}.", words.join(", "));
    text.push_str("\n```toml\n[compare]\ndesk = [498.2, 512.7]\n```\n");
    text
}

/// Writes a table of keys and an example.
fn section(text: &mut String, heading: &str, about: &str, kind: &str, name: &str) {
    let keys = keys(&CODE.concat(), name);
    let about = if about.is_empty() { &keys.about } else { about };
    let _ = write!(text, "\n### `{heading}`\n\n{about}\n\n");
    text.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
    let mut lines = Vec::new();
    let kind = if name == "WrittenLine" { "line" } else { kind };
    for field in &keys.fields {
        let default = field.default.as_deref().unwrap_or("");
        let (key, value) = (&field.name, value_of(field));
        let _ = writeln!(text, "| `{key}` | {value} | {default} | {} |", field.meaning);
        let line = example(kind, key).expect("an example in suggest.rs");
        lines.push((field, line));
    }
    if !heading.starts_with('[') {
        return;
    }
    let is_needed =
        |field: &Field| field.default.is_none() || field.meaning.contains("Exactly one of this");
    let has_needed = keys.fields.iter().any(is_needed);
    let shown = lines.iter().filter(|(field, _)| is_needed(field) || !has_needed);
    let body: Vec<&str> = shown.map(|(_, line)| *line).collect();
    if !body.is_empty() {
        let _ = write!(text, "\n```toml\n{heading}\n{}\n```\n", body.join("\n"));
    }
}

/// Lists the variants of an enum, what each holds and what is said of it.
fn variants(code: &str, name: &str) -> Vec<(String, String, String)> {
    let (mut variants, mut about) = (Vec::new(), String::new());
    for line in body(code, &format!("enum {name} {{")).lines().map(str::trim) {
        if let Some(more) = line.strip_prefix("/// ") {
            about = joined(&about, more);
        } else if let Some((variant, rest)) = line.split_once('(') {
            let inner = rest.trim_end_matches("),");
            variants.push((variant.to_owned(), inner.to_owned(), std::mem::take(&mut about)));
        }
    }
    variants
}

/// Reads the fields of a struct.
fn keys(code: &str, name: &str) -> Keys {
    let opening = format!("struct {name} {{");
    let before = code.split(&opening).next().expect("code before it");
    let attributes = before.rsplit("\n\n").next().expect("its attributes");
    let all_optional = attributes.contains("#[serde(default,");
    let docs = attributes.lines().filter_map(|line| line.strip_prefix("/// "));
    let about = docs.fold(String::new(), |all, line| joined(&all, line));
    let (mut fields, mut meaning, mut serde) = (Vec::new(), String::new(), String::new());
    for line in body(code, &opening).lines().map(str::trim) {
        if let Some(more) = line.strip_prefix("/// ") {
            meaning = joined(&meaning, more);
        } else if let Some(attribute) = line.strip_prefix("#[serde(") {
            serde = attribute.trim_end_matches(")]").to_owned();
        } else if let Some((name, r#type)) = line.trim_end_matches(',').split_once(": ") {
            let name = name.rsplit(' ').next().expect("a name").to_owned();
            let reader = serde.split("deserialize_with = \"").nth(1).unwrap_or("");
            let reader = reader.trim_end_matches('"').to_owned();
            let is_optional =
                all_optional || serde.contains("default") || r#type.starts_with("Opt");
            let default = is_optional.then(|| default_of(r#type, &serde, &name));
            assert!(!meaning.is_empty(), "{name} has no words");
            // The reader gives it that length.
            let meaning = std::mem::take(&mut meaning).replace(", of length 1", "");
            serde.clear();
            fields.push(Field { name, reader, r#type: r#type.to_owned(), default, meaning });
        }
    }
    assert!(!fields.is_empty(), "{name} has no keys");
    Keys { about, fields }
}

/// Returns what stands between an opening brace and the line that closes it.
fn body<'a>(code: &'a str, opening: &str) -> &'a str {
    let inner = code.split_once(opening).unwrap_or_else(|| panic!("no {opening}")).1;
    inner.split_once("\n}").expect("its end").0
}

fn joined(before: &str, line: &str) -> String {
    if before.is_empty() { line.to_owned() } else { format!("{before} {line}") }
}

/// Returns the words for what a key is left out for.
fn default_of(r#type: &str, serde: &str, name: &str) -> String {
    let of_function = serde.split("default = \"").nth(1).and_then(|rest| rest.split('"').next());
    let of_type = match r#type {
        "bool" => "`false`".to_owned(),
        "f64" if name == "pixels" => "0.25".to_owned(),
        "f64" if name == "normal" => "180".to_owned(),
        "u64" | "Rgb" | "f64" => "0".to_owned(),
        "DVec3" => "`[0, 0, 0]`".to_owned(),
        "Exposure" => "by the mean".to_owned(),
        "MeasureName" => "`\"plane\"`".to_owned(),
        "Rotation" | "StopSpec" => "none".to_owned(),
        "Intersector" => format!("`\"{}\"`", Intersector::NAMES[0]),
        "RenderEstimator" => named(RenderEstimator::default()),
        "IllumEstimator" => named(IllumEstimator::default()),
        "Filter" => named(Filter::default()),
        "Tone" => named(Tone::default()),
        "FisheyeMapping" => named(FisheyeMapping::default()),
        "Unit" => named(Unit::default()),
        "UpAxis" => named(UpAxis::default()),
        _ if r#type.starts_with("Option<") || r#type.starts_with("BTreeMap<") => "none".to_owned(),
        _ => panic!("teach this reference the default of {type}"),
    };
    match of_function {
        None => of_type,
        Some("one") => "1".to_owned(),
        Some("white") => "`[1, 1, 1]`".to_owned(),
        Some("glass") => "1.5".to_owned(),
        Some("half_of_all") => "180".to_owned(),
        Some(other) => panic!("teach this reference the value of `{other}`"),
    }
}

fn named<T: Choice>(value: T) -> String {
    let at = T::ALL.iter().position(|other| *other == value).expect("one of all");
    format!("`\"{}\"`", T::NAMES[at])
}

fn words<T: Choice>() -> String {
    quoted(T::NAMES)
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|name| format!("`\"{name}\"`")).collect::<Vec<_>>().join(", ")
}

/// Returns the words for what a key takes.
fn value_of(field: &Field) -> String {
    let reader = field.reader.trim_end_matches(", _>").trim_end_matches(", _");
    let range = reader.split("::<").nth(1).unwrap_or("");
    let number = || format!("a number {}", range_of(range)).replace("a number finite", "a number");
    match (reader.split("::").next().unwrap_or(""), field.r#type.as_str()) {
        ("number" | "number_if", _) => number(),
        ("spectrum", _) => format!("a number or `[r, g, b]`, {}", range_of(range)),
        ("whole", "u64") => "a whole number".to_owned(),
        ("whole", "usize") => "0 to 1400".to_owned(),
        ("count_if", _) => "a whole number from 1".to_owned(),
        ("several_if", _) => "a whole number from 2".to_owned(),
        ("points_if", _) => "1 to 1 000 000".to_owned(),
        ("patches_if", _) => "1 to 100 000".to_owned(),
        ("point" | "point_if", _) => "`[x, y, z]`".to_owned(),
        ("points", _) => "`[[x, y, z], ...]`".to_owned(),
        ("direction" | "direction_if", _) => "a direction".to_owned(),
        ("colour", _) => "`[r, g, b]`".to_owned(),
        ("columns_rows" | "columns_rows_if", _) => "`[columns, rows]`".to_owned(),
        ("crop_if", _) => "`[left, top, right, bottom]`".to_owned(),
        ("time_if", _) => "a time: `\"10m\"`, `\"90s\"`, `\"1.5h\"`, or seconds".to_owned(),
        ("layers_if", _) => words::<crate::scene::Layer>(),
        ("exposure", _) => "a number above 0, or `\"98%\"`".to_owned(),
        ("shares", _) => "`{ NAME = share, ... }`".to_owned(),
        ("table" | "table_if", _) => format!("a table, see [`{0}`](#{0})", field.name),
        ("word", "MeasureName") => {
            "`\"plane\"`, `\"cylindrical\"`, `\"semicylindrical\"`".to_owned()
        }
        ("intersector", _) => quoted(Intersector::NAMES),
        ("choice", "RenderEstimator") => words::<RenderEstimator>(),
        ("choice", "IllumEstimator") => words::<IllumEstimator>(),
        ("choice", "Filter") => words::<Filter>(),
        ("choice", "Tone") => words::<Tone>(),
        ("choice", "FisheyeMapping") => words::<FisheyeMapping>(),
        ("choice", "Unit") => words::<Unit>(),
        ("choice", "UpAxis") => words::<UpAxis>(),
        ("", "bool") => "`true` or `false`".to_owned(),
        ("", "String" | "Option<String>") => "a name".to_owned(),
        ("", "FileRef") => "a path".to_owned(),
        ("", "Option<Spacing>") => "a number above 0, or `\"en12464\"`".to_owned(),
        ("", "BTreeMap<BoxFace, String>") => "`{ FACE = name, ... }`".to_owned(),
        (reader, r#type) => panic!("teach this reference `{reader}` of {type}"),
    }
}

/// Returns what a range of numbers says of itself.
fn range_of(range: &str) -> &'static str {
    macro_rules! must {
        ($($name:ident)*) => {
            match range {
                $(stringify!($name) => values::$name::MUST,)*
                other => panic!("teach this reference the range {other}"),
            }
        };
    }
    must!(Any Above0 AtLeast0 Albedo Opening Turn HalfTurn Share Part AreaShare Roughness Index Size
          Coordinate)
}

#[test]
fn examples_name_each_key_once() {
    let text = reference();
    let headings: Vec<&str> = text.lines().filter(|line| line.starts_with("### ")).collect();
    let distinct: BTreeSet<&&str> = headings.iter().collect();
    assert_eq!(distinct.len(), headings.len());
    assert!(!text.contains("::"), "no paths of the code:\n{text}");
}
