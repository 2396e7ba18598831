//! Writes that fail, one after the other, whatever writes a file.

use std::fs;
use std::io::{self, Cursor, ErrorKind, Read, Seek, SeekFrom, Write};

use super::output::{Kind, Output, ReadWriteSeek, Stage};

/// A file that takes so many writes, each of 64 bytes at most.
struct Failing {
    file: Cursor<Vec<u8>>,
    left: usize,
}

impl Write for Failing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.left = self.left.checked_sub(1).ok_or(ErrorKind::StorageFull)?;
        self.file.write(&bytes[..bytes.len().min(64)])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for Failing {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.read(bytes)
    }
}

impl Seek for Failing {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Fills files whose first write fails, whose second, and so on, until all succeed; each failure is
/// told, and leaves the file that stood there as it was. Returns the number of writes.
pub(super) fn in_turn(
    kind: &Kind,
    extension: &str,
    fill: &mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>,
) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("old").with_extension(extension);
    fs::write(&path, "old").expect("written");
    for count in 0.. {
        let mut output = Output::open(&path, kind, true).expect("may be replaced");
        let mut file = Failing { file: Cursor::default(), left: count };
        let done = output.write_with(Stage::Complete, &mut |to| {
            let filled = fill(&mut file);
            to.write_all(file.file.get_ref())?;
            filled
        });
        drop(output);
        let now = fs::read(&path).expect("there");
        assert_eq!(
            fs::read_dir(folder.path()).expect("there").count(),
            1,
            "nothing is left beside"
        );
        match done {
            Ok(()) => {
                assert!(
                    now == *file.file.get_ref() && file.left == 0,
                    "one of {count} is not told"
                );
                return count;
            }
            Err(error) => assert!(error.to_string().contains("cannot write: "), "{error}"),
        }
        assert_eq!(now, b"old");
    }
    unreachable!("a usize has an end")
}

#[test]
fn every_failed_write_of_bytes_is_told() {
    let bytes = [7; 1000];
    for (kind, extension) in [
        (Kind::COEFFICIENTS, "txt"),
        (Kind::JSON, "json"),
        (Kind::NPY, "npy"),
        (Kind::PNG, "png"),
        (Kind::SVG, "svg"),
    ] {
        let writes = in_turn(&kind, extension, &mut |file| file.write_all(&bytes));
        assert_eq!(writes, 16, "{extension}");
    }
}
