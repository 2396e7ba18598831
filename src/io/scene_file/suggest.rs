//! What to write instead: the nearest valid name, or the valid names, or an example of a missing
//! key.

/// Names what was probably meant, else lists what is valid; `what` is the plural of the names
/// ("keys here", "materials").
pub(super) fn suggest<S: AsRef<str>>(found: &str, valid: &[S], what: &str) -> String {
    match nearest(found, valid) {
        Some(name) => format!("did you mean `{name}`?"),
        None if valid.is_empty() => format!("there are no {what}"),
        None if valid.len() == 1 => format!("of {what} there is only {}", list(valid)),
        None => format!("the {what} are {}", list(valid)),
    }
}

/// The bytes of the longest name that is compared with others.
const LONGEST: usize = 100;

/// Finds the nearest name by Damerau-Levenshtein distance, if no more than a third of its letters
/// (and two at least) are wrong.
pub(super) fn nearest<'a, S: AsRef<str>>(found: &str, valid: &'a [S]) -> Option<&'a str> {
    // The time grows as the product of both lengths.
    let is_short = |name: &&str| name.len() <= LONGEST;
    let found = Some(found).filter(is_short)?.to_lowercase();
    let distance = |name: &str| strsim::damerau_levenshtein(&found, &name.to_lowercase());
    let names = valid.iter().map(AsRef::as_ref).filter(is_short);
    let ranked = names.map(|name| (distance(name), name));
    let (distance, name) = ranked.min_by_key(|&(distance, _)| distance)?;
    // A name of which nothing is left is no misspelling: `x` is not `at`.
    let length = name.chars().count();
    (distance <= (length / 3).max(2) && distance < length.min(found.chars().count().max(1)))
        .then_some(name)
}

/// Writes names as `a`, `b` and `c`.
pub(super) fn list<S: AsRef<str>>(names: &[S]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.as_ref())).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// Returns an example of a key in things of a kind.
pub(super) fn example(kind: &str, key: &str) -> Option<&'static str> {
    match (kind, key) {
        ("sensors", "at") => Some("at = [[1, 1, 0], [2, 1, 0]]"),
        ("line", "count") => Some("count = 20"),
        ("line", "spacing") => Some("spacing = 0.5"),
        ("detail", "normal") => Some("normal = 2"),
        ("cameras", "up") => Some("up = [0, 0, 1]"),
        ("cameras", "height") => Some("height = 4"),
        _ => EXAMPLES.iter().copied().find(|line| line.split(" = ").next() == Some(key)),
    }
}

const EXAMPLES: [&str; 68] = [
    "roughness = 0.3",
    "index = 1.5",
    "intersector = \"certified\"",
    "tone = \"filmic\"",
    "checkpoint = \"60s\"",
    "patches = 2000",
    "of = { silver = 0.85, dust = 0.15 }",
    "points = 1000",
    "vertices = true",
    "measure = \"cylindrical\"",
    "facing = [1, 0, 0]",
    "direction = [0, 0, -1]",
    "inner = 15",
    "outer = 25",
    "format = 1",
    "reflectance = 0.5",
    "exitance = 100",
    "min = [0, 0, 0]",
    "max = [4, 5, 3]",
    "inward = true",
    "material = \"walls\"",
    "faces = { z_min = \"floor\" }",
    "corner = [0, 0, 0]",
    "edge_u = [2, 0, 0]",
    "edge_v = [0, 1, 0]",
    "centre = [1, 1, 1]",
    "normal = [0, 0, 1]",
    "radius = 0.5",
    "point = [0, 0, 0]",
    "file = \"../head.obj\"",
    "degree = 32",
    "at = [1, 1, 1]",
    "scale = 6",
    "up = \"y\"",
    "unit = \"mm\"",
    "rotate = { axis = [0, 0, 1], degrees = 25 }",
    "axis = [0, 0, 1]",
    "degrees = 25",
    "smooth = true",
    "step = 0.01",
    "tolerance = 1e-6",
    "intensity = 100",
    "flux = 1000",
    "colour = [1, 0.9, 0.8]",
    "from = [2.2, 0.3, 1.5]",
    "to = [2.0, 2.9, 0.95]",
    "fov = 45",
    "width = 5",
    "mapping = \"equisolid\"",
    "filter = \"gaussian\"",
    "crop = [100, 50, 420, 290]",
    "layers = [\"normal\", \"depth\"]",
    "resolution = [640, 480]",
    "on = \"room.z_min\"",
    "height = 0.75",
    "border = 0.5",
    "spacing = \"en12464\"",
    "count = [8, 10]",
    "estimator = \"path\"",
    "camera = \"main\"",
    "seed = 1",
    "stop = { relative_error = 0.01, time = \"10m\" }",
    "relative_error = 0.01",
    "time = \"10m\"",
    "walks = 100000",
    "exposure = 0.02",
    "detail = { pixels = 0.25 }",
    "pixels = 0.25",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_near_nothing() {
        assert_eq!(nearest("", &["at"]), None);
        assert_eq!(nearest::<&str>("at", &[]), None);
        assert_eq!(nearest("x", &["at", "to"]), None);
    }

    #[test]
    fn transposed_dropped_and_capital_letters_are_forgiven() {
        assert_eq!(nearest("reflectence", &["exitance", "reflectance"]), Some("reflectance"));
        assert_eq!(nearest("fvo", &["from", "to", "fov"]), Some("fov"));
        assert_eq!(nearest("Walls", &["floor", "walls"]), Some("walls"));
        assert_eq!(nearest("colour_temperature", &["colour", "at"]), None);
    }

    #[test]
    fn names_too_long_to_be_misspelt_are_not_compared() {
        let [long, longer] = [200_000, 200_001].map(|n| "a".repeat(n));
        assert_eq!(nearest(&long, &[&longer, "walls"]), None);
        assert_eq!(nearest("wals", &[&long, "walls"]), Some("walls"));
    }

    #[test]
    fn lists_read_as_sentences() {
        assert_eq!(suggest("zzz", &["a", "b", "c"], "keys"), "the keys are `a`, `b` and `c`");
        assert_eq!(suggest("zzz", &["lambert"], "types"), "of types there is only `lambert`");
        assert_eq!(suggest::<&str>("zzz", &[], "cameras"), "there are no cameras");
    }
}
