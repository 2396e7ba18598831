//! Paths in JSON: text, and the bytes of one that is no UTF-8.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Puts a path into an object.
pub(crate) fn put(object: &mut Value, key: &str, path: &Path) {
    object[key] = json!(path.to_string_lossy());
    if path.to_str().is_none() {
        object[format!("{key}_bytes")] = bytes(path);
    }
}

/// Puts a list of paths into an object.
pub(crate) fn put_all<'a>(
    object: &mut Value,
    key: &str,
    paths: impl IntoIterator<Item = &'a Path, IntoIter: Clone>,
) {
    let paths = paths.into_iter();
    object[key] = paths.clone().map(Path::to_string_lossy).collect();
    if paths.clone().any(|path| path.to_str().is_none()) {
        object[format!("{key}_bytes")] = paths.map(bytes).collect();
    }
}

/// Returns the bytes of a path in base64; null for one that is UTF-8.
fn bytes(path: &Path) -> Value {
    match path.to_str() {
        Some(_) => Value::Null,
        None => STANDARD.encode(path.as_os_str().as_encoded_bytes()).into(),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn bytes_stand_beside_the_text_of_a_path_that_is_no_utf8() {
        let (plain, odd) = (Path::new("a.txt"), Path::new(OsStr::from_bytes(b"\xff.txt")));
        let mut value = json!({});
        put(&mut value, "read", plain);
        put(&mut value, "written", odd);
        assert_eq!(
            value,
            json!({ "read": "a.txt", "written": "\u{fffd}.txt", "written_bytes": "/y50eHQ=" })
        );
        for (paths, expected) in [
            (vec![], json!({ "written": [] })),
            (vec![plain], json!({ "written": ["a.txt"] })),
            (
                vec![plain, odd],
                json!({
                    "written": ["a.txt", "\u{fffd}.txt"],
                    "written_bytes": [null, "/y50eHQ="],
                }),
            ),
        ] {
            let mut value = json!({});
            put_all(&mut value, "written", paths);
            assert_eq!(value, expected);
        }
    }
}
