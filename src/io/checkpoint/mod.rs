//! Checkpoints: a picture under way, to be taken up again to the bit, and what must be the same for
//! that.
//!
//! Little endian. A text is its length in bytes (4 bytes) and UTF-8.
//!
//! ```text
//! bytes  what
//!     8  89 48 58 4b 0d 0a 1a 0a: damaged by every transfer that takes the file for text
//!     2  version, 1
//!     4  number of fields; of each its name and its value follow, two texts
//!    12  width, height, replicates
//!     8  passes
//!     1  1 when the present stage was planned, else 0
//!    16  samples, non-finite samples
//!    24  flux that left the scene: R, G, B
//!     4  CRC-32 of all bytes before
//! ```
//!
//! Then for each pixel, top row first: sums of direct and indirect light (6 x 8 bytes), weight of
//! non-finite samples, spread (2 x 4), logarithm of the stride (1), sums of the replicates (4
//! each); and the CRC-32 of all bytes before. Nothing follows. A field says what must be the same
//! for a run to go on.

mod fingerprint;

use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::Path;

pub use fingerprint::Fingerprint;

use super::bytes::{Number, field};
use super::output::{Claim, Kind};
use crate::error::{Advice, InputError};
use crate::math::Rgb;
use crate::scene::{Film, MAX_STRIDE_LOG2, SplitLight};
use crate::{Error, Result};

/// Begins every checkpoint.
pub const MAGIC: [u8; 8] = *b"\x89HXK\r\n\x1a\n";

const VERSION: u16 = 1;

/// The bytes of a pixel without those of its replicates.
const PIXEL: usize = 57;

/// More fields, and longer texts, are no header of ours.
const MOST_FIELDS: u32 = 1 << 16;
const LONGEST_TEXT: u32 = 1 << 24;

impl Kind {
    /// A checkpoint of a picture.
    pub const CHECKPOINT: Self = Self::signed("a checkpoint", &["checkpoint"], &MAGIC);
}

impl Fingerprint {
    /// Returns the text by which files of this run are told from those of others.
    pub fn run(&self) -> String {
        let mut check = crc32fast::Hasher::new();
        for text in self.fields.iter().flat_map(|(name, value)| [name, value]) {
            check.update(&(text.len() as u64).to_le_bytes());
            check.update(text.as_bytes());
        }
        format!("CRC-32 {:08x}", check.finalize())
    }
}

/// Writes a film and its fingerprint, whole or not at all.
///
/// # Errors
/// [`Error::Io`] when the system refuses; what stood there before is as it was.
pub fn write(to: &mut Claim, fingerprint: &Fingerprint, film: &Film) -> Result<()> {
    to.write_with(&mut |file| encode(file, fingerprint, film))
}

fn encode(to: impl Write, fingerprint: &Fingerprint, film: &Film) -> io::Result<()> {
    let mut sealed = Sealed { inner: BufWriter::new(to), check: crc32fast::Hasher::new() };
    write_header(&mut sealed, fingerprint, film)?;
    sealed.seal()?;
    let sums = film.sums.chunks_exact(film.replicates);
    let mut bytes = Vec::new();
    for (pixel, sums) in film.pixels.iter().zip(sums) {
        bytes.clear();
        let SplitLight { direct, indirect } = pixel.light;
        for value in direct.0.iter().chain(&indirect.0) {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(pixel.non_finite.to_le_bytes());
        bytes.extend(pixel.spread.to_le_bytes());
        bytes.push(pixel.stride);
        bytes.extend(sums.iter().flat_map(|sum| sum.to_le_bytes()));
        sealed.write_all(&bytes)?;
    }
    sealed.seal()?;
    sealed.inner.flush()
}

fn write_header(file: &mut impl Write, fingerprint: &Fingerprint, film: &Film) -> io::Result<()> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((fingerprint.fields.len() as u32).to_le_bytes());
    for text in fingerprint.fields.iter().flat_map(|(name, value)| [name, value]) {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
    let [width, height] = film.size();
    for number in [width, height, film.replicates] {
        bytes.extend((number as u32).to_le_bytes());
    }
    bytes.extend(film.passes.to_le_bytes());
    bytes.push(u8::from(film.planned));
    bytes.extend([film.samples, film.non_finite].iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(film.escaped.0.iter().flat_map(|v| v.to_le_bytes()));
    file.write_all(&bytes)
}

/// Keeps the CRC-32 of what goes through.
struct Sealed<F> {
    inner: F,
    check: crc32fast::Hasher,
}

impl<F: Write> Sealed<F> {
    fn seal(&mut self) -> io::Result<()> {
        let check = self.check.clone().finalize();
        self.write_all(&check.to_le_bytes())
    }
}

impl<F: Write> Write for Sealed<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.check.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Reads the film of a checkpoint whose run is the one of `present`.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`] when it is no checkpoint, damaged,
/// of another version, or of a run that differs, with the first difference; [`Error::Parameter`]
/// or [`Error::Memory`] when the film is beyond what can be held.
pub fn read(path: &Path, present: &Fingerprint) -> Result<Film> {
    let file = File::open(path).map_err(|e| Error::io(path, "read", e))?;
    read_from(path, file, present)
}

/// As [`read`], of a file that is open: where locks keep others from reading, only its holder can.
///
/// # Errors
/// As [`read`].
pub fn read_from(path: &Path, file: File, present: &Fingerprint) -> Result<Film> {
    let length = file.metadata().map_err(|e| Error::io(path, "read", e))?.len();
    parse_from(path, BufReader::new(file), length, present)
}

/// As [`read`], of the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], present: &Fingerprint) -> Result<Film> {
    parse_from(path, bytes, bytes.len() as u64, present)
}

fn parse_from(path: &Path, file: impl Read, length: u64, present: &Fingerprint) -> Result<Film> {
    let mut from = Reader { path, file, length, check: crc32fast::Hasher::new(), taken: 0 };
    let header = from.header(present)?;
    let [width, height, replicates] = header.size;
    let pixels = u64::from(width) * u64::from(height);
    let rest = pixels.saturating_mul(PIXEL as u64 + 4 * u64::from(replicates)).saturating_add(4);
    if length.saturating_sub(from.taken) != rest {
        return Err(from.broken("it is cut off, or something follows it"));
    }
    let mut film = Film::new([width, height], replicates as usize)?;
    film.passes = header.passes;
    film.planned = header.planned;
    [film.samples, film.non_finite] = header.samples;
    film.escaped = header.escaped;
    from.pixels(&mut film)?;
    Ok(film)
}

struct Header {
    size: [u32; 3],
    passes: u64,
    planned: bool,
    samples: [u64; 2],
    escaped: Rgb,
}

/// Takes bytes from a checkpoint, and says what is wrong in terms of the file.
struct Reader<'a, R> {
    path: &'a Path,
    file: R,
    length: u64,
    check: crc32fast::Hasher,
    taken: u64,
}

impl<R: Read> Reader<'_, R> {
    fn header(&mut self, present: &Fingerprint) -> Result<Header> {
        let mut start = [0; MAGIC.len()];
        self.fill(&mut start)?;
        if start != MAGIC {
            let help = "name the file that `render` left, NAME.checkpoint";
            return Err(InputError::new(self.path, "this is no checkpoint").help(help).into());
        }
        let version = self.take::<u16>()?;
        if version != VERSION {
            let message = format!("version {version} of checkpoints; known here is {VERSION}");
            let advice = Advice::BeginAnew(Some("go on with the harmolux that wrote it, or "));
            return Err(InputError::new(self.path, message).advise(advice).into());
        }
        let count = self.take::<u32>()?;
        if count > MOST_FIELDS {
            return Err(self.broken("its header is damaged"));
        }
        let mut then = Fingerprint::default();
        for _ in 0..count {
            let field = (self.text()?, self.text()?);
            then.fields.push(field);
        }
        let size = [self.take::<u32>()?, self.take::<u32>()?, self.take::<u32>()?];
        let passes = self.take::<u64>()?;
        let planned = self.take::<u8>()?;
        let samples = [self.take::<u64>()?, self.take::<u64>()?];
        let escaped = Rgb([self.take()?, self.take()?, self.take()?]);
        self.compare_seal("its header is damaged")?;
        if let Some(difference) = then.difference(present) {
            let message = format!("this checkpoint is of another run: {difference}");
            let first = "go on with what it was made with (only the stop may change), or ";
            let advice = Advice::BeginAnew(Some(first));
            return Err(InputError::new(self.path, message).advise(advice).into());
        }
        if size.contains(&0) || size[2] < 2 || planned > 1 {
            return Err(self.broken("its header makes no sense"));
        }
        Ok(Header { size, passes, planned: planned == 1, samples, escaped })
    }

    fn pixels(&mut self, film: &mut Film) -> Result<()> {
        let replicates = film.replicates;
        let mut bytes = vec![0; PIXEL + 4 * replicates];
        for (pixel, sums) in film.pixels.iter_mut().zip(film.sums.chunks_exact_mut(replicates)) {
            self.fill(&mut bytes)?;
            let double = |i: usize| field::<f64>(&bytes, 8 * i);
            pixel.light.direct = Rgb([double(0), double(1), double(2)]);
            pixel.light.indirect = Rgb([double(3), double(4), double(5)]);
            pixel.non_finite = field::<f32>(&bytes, 48);
            pixel.spread = field::<f32>(&bytes, 52);
            pixel.stride = bytes[PIXEL - 1];
            if pixel.stride > MAX_STRIDE_LOG2 {
                return Err(self.broken("it is damaged"));
            }
            for (r, sum) in sums.iter_mut().enumerate() {
                *sum = field::<f32>(&bytes, PIXEL + 4 * r);
            }
        }
        self.compare_seal("it is damaged")
    }

    fn compare_seal(&mut self, otherwise: &str) -> Result<()> {
        let expected = self.check.clone().finalize();
        if self.take::<u32>()? == expected { Ok(()) } else { Err(self.broken(otherwise)) }
    }

    fn text(&mut self) -> Result<String> {
        let length = self.take::<u32>()?;
        if length > LONGEST_TEXT {
            return Err(self.broken("its header is damaged"));
        }
        if u64::from(length) > self.length.saturating_sub(self.taken) {
            return Err(self.broken("it is cut off"));
        }
        let mut bytes = vec![0; length as usize];
        self.fill(&mut bytes)?;
        String::from_utf8(bytes).map_err(|_| self.broken("its header is damaged"))
    }

    fn take<T: Number>(&mut self) -> Result<T> {
        let mut bytes = T::Bytes::default();
        self.fill(bytes.as_mut())?;
        Ok(T::of(bytes))
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        match self.file.read_exact(bytes) {
            Ok(()) => {
                self.check.update(bytes);
                self.taken += bytes.len() as u64;
                Ok(())
            }
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => Err(self.broken("it is cut off")),
            Err(e) => Err(Error::io(self.path, "read", e)),
        }
    }

    fn broken(&self, what: &str) -> Error {
        InputError::new(self.path, format!("this checkpoint cannot be used: {what}"))
            .advise(Advice::BeginAnew(None))
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::failing;
    use crate::io::output::ReadWriteSeek;
    use std::fs;
    use std::path::PathBuf;

    fn film() -> Film {
        let mut film = Film::new([3, 2], 4).expect("small");
        for pass in 0..13 {
            if film.is_between_stages() {
                film.plan(Some(0.3));
            }
            let light = |i: u32| Rgb::grey(f64::from(pass * i % 5));
            let sample = |i| SplitLight { direct: light(i), indirect: light(i + 1) };
            film.add_pass(&[0, 1, 2, 3, 4, 5].map(sample));
            film.add_escaped(Rgb([0.1, 0.2, 0.3]));
        }
        film
    }

    fn run(seed: u32) -> Fingerprint {
        Fingerprint::new().with("size", "3 x 2").with("seed", seed.to_string())
    }

    fn written() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("room.checkpoint");
        for _ in 0..2 {
            let claim = Claim::open(&path, &Kind::CHECKPOINT, false);
            let mut claim = claim.expect("free, then ours");
            write(&mut claim, &run(1), &film()).expect("written");
        }
        (folder, path)
    }

    #[test]
    fn every_failed_write_is_told() {
        let fill = &mut |file: &mut dyn ReadWriteSeek| encode(file, &run(1), &film());
        assert!(failing::in_turn(&Kind::CHECKPOINT, "checkpoint", fill) > 5);
    }

    #[test]
    fn film_comes_back_to_the_bit() {
        let (_folder, path) = written();
        assert_eq!(read(&path, &run(1)).expect("the same run"), film());
        let claim = Claim::open(&path, &Kind::CHECKPOINT, false).expect("free");
        for _ in 0..2 {
            let file = claim.file().expect("held");
            assert_eq!(read_from(&path, file, &run(1)).expect("the same run"), film());
        }
    }

    #[test]
    fn runs_have_texts_of_their_own() {
        assert_eq!(run(1).run(), run(1).run());
        assert!(run(1).run() != run(2).run());
        let joined = Fingerprint::default().with("ab", "c").run();
        assert!(joined != Fingerprint::default().with("a", "bc").run());
    }

    #[test]
    fn another_run_is_refused_with_the_difference() {
        let (_folder, path) = written();
        let refusal =
            |present: &Fingerprint| read(&path, present).expect_err("refused").to_string();
        let message = refusal(&run(2));
        assert!(message.contains("another run: seed was `1`, is `2`"), "{message}");
        let message = refusal(&run(1).with("objects.head", "Sh"));
        assert!(message.contains("objects.head was not there, is `Sh`"), "{message}");
        let message = refusal(&Fingerprint::new().with("size", "3 x 2"));
        assert!(message.contains("seed was `1`, is not there"), "{message}");
    }

    #[test]
    fn damaged_and_foreign_files_are_refused() {
        let (_folder, path) = written();
        let good = fs::read(&path).expect("there");
        let refusal = |bytes: &[u8]| {
            fs::write(&path, bytes).expect("writable");
            let error = read(&path, &run(1)).expect_err("refused");
            assert!(matches!(error, Error::Input(_)), "{error}");
            error.to_string()
        };
        assert!(refusal(b"a picture of something").contains("this is no checkpoint"));
        let mut newer = good.clone();
        newer[8] = 2;
        assert!(refusal(&newer).contains("version 2 of checkpoints; known here is 1"));
        for at in (10..good.len()).step_by(7) {
            let mut damaged = good.clone();
            damaged[at] ^= 0x10;
            refusal(&damaged);
        }
        for end in (0..good.len()).step_by(11) {
            refusal(&good[..end]);
        }
        assert!(refusal(&[good, vec![0]].concat()).contains("something follows"));
    }
}
