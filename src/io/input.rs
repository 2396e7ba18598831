//! The one door through which files come in. Each is opened once and read once, and what was read
//! of it is known by its length and fingerprint.
//!
//! Nothing goes back: the format is told by what [`Input::ahead`] shows, so that a pipe is read as
//! a file is. Its length is not known before its end, so it is held in memory; and so is what a
//! file packed by gzip, told by its first bytes, holds.

use std::fmt;
use std::fs::{self, File, FileType};
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use crate::error::InputError;
use crate::fit::{Source, SourceHash};
use crate::{Error, Result, memory};

/// How much of a file is seen at once, bytes: what tells its format is within.
const BUFFER: usize = 1 << 16;

/// The most that is taken from a pipe, bytes.
const MOST_OF_PIPE: u64 = 1 << 30;

/// How a file packed by gzip begins: its mark, and the one method there is.
const GZIP: &[u8] = b"\x1f\x8b\x08";

/// Reads a file, or a pipe, from its beginning to its end.
pub struct Input<'a> {
    path: &'a Path,
    reader: BufReader<Hashed<'a>>,
    length: u64,
    /// The file itself, where what is read was unpacked from it.
    packed: Option<FileRead>,
    beside: Vec<FileRead>,
    remarks: Vec<String>,
}

/// Keeps length and fingerprint of what goes through.
struct Hashed<'a> {
    from: Box<dyn Read + 'a>,
    length: u64,
    hash: SourceHash,
}

impl Read for Hashed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.from.read(bytes)?;
        self.length += read as u64;
        self.hash = self.hash.followed_by(&bytes[..read]);
        Ok(read)
    }
}

impl<'a> Input<'a> {
    /// Opens a file or a pipe. A pipe is read into memory here, and what is packed by gzip is
    /// unpacked.
    ///
    /// # Errors
    /// [`Error::Input`] for a folder, a device or a socket, for more than 1 GiB from a pipe, and for
    /// a gzip file that is damaged; [`Error::Memory`] when what it holds takes more than a third of
    /// the memory that is free; [`Error::Io`] when it cannot be read.
    pub fn open(path: &'a Path) -> Result<Self> {
        let refused = |e| Error::io(path, "read", e);
        if !is_pipe(fs::metadata(path).map_err(refused)?.file_type()) {
            return Self::open_file(path);
        }
        let pipe = File::open(path).map_err(refused)?;
        let bytes = memory::read_to_end(path, pipe.take(MOST_OF_PIPE + 1))?;
        let length = bytes.len() as u64;
        if length > MOST_OF_PIPE {
            let error = InputError::new(path, "more than 1 GiB comes through this pipe");
            return Err(error.help(HELP_FOR_PIPES).into());
        }
        Self::new(path, Box::new(Cursor::new(bytes)), length).unpacked()
    }

    /// Opens a file. What is none is refused before it is opened: a pipe that nobody writes to
    /// would be waited for without end.
    ///
    /// # Errors
    /// [`Error::Input`] for anything but a file, else as [`Input::open`].
    pub fn open_file(path: &'a Path) -> Result<Self> {
        Self::open_start(path, u64::MAX)?.unpacked()
    }

    /// Opens the first `most` bytes of a file, or all where it has no more.
    fn open_start(path: &'a Path, most: u64) -> Result<Self> {
        let refused = |e| Error::io(path, "read", e);
        let known = fs::metadata(path).map_err(refused)?;
        if !known.is_file() {
            return Err(no_file(path, known.file_type()));
        }
        let file = File::open(path).map_err(refused)?;
        let length = file.metadata().map_err(refused)?.len().min(most);
        Ok(Self::new(path, Box::new(file.take(most)), length))
    }

    /// Takes bytes for the content of a file; `path` is for errors.
    pub fn of_bytes(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(path, Box::new(bytes), bytes.len() as u64)
    }

    fn new(path: &'a Path, from: Box<dyn Read + 'a>, length: u64) -> Self {
        let hashed = Hashed { from, length: 0, hash: SourceHash::of(&[]) };
        let reader = BufReader::with_capacity(BUFFER, hashed);
        Self { path, reader, length, packed: None, beside: Vec::new(), remarks: Vec::new() }
    }

    /// Reads what a file packed by gzip holds in its place.
    fn unpacked(mut self) -> Result<Self> {
        if !self.ahead()?.starts_with(GZIP) {
            return Ok(self);
        }
        let path = self.path;
        let mut unpacker = MultiGzDecoder::new(self);
        let bytes = memory::read_to_end(path, &mut unpacker).map_err(|e| damaged(path, e))?;
        let packed = unpacker.into_inner().finish()?.file;
        let length = bytes.len() as u64;
        let content = Self::new(path, Box::new(Cursor::new(bytes)), length);
        Ok(Self { packed: Some(packed), ..content })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &'a Path {
        self.path
    }

    /// Returns the name whose extension is that of the content: `a.obj` of the packed `a.obj.gz`.
    pub fn name(&self) -> &'a Path {
        let is_gz = self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        let stem = self.path.file_stem().filter(|_| is_gz && self.packed.is_some());
        stem.map_or(self.path, Path::new)
    }

    /// Returns the length of the content as it was opened, bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Shows the bytes that come next, at the beginning of a file 64 KiB or all of them, without
    /// taking them.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read.
    pub fn ahead(&mut self) -> Result<&[u8]> {
        self.reader.fill_buf().map_err(|e| Error::io(self.path, "read", e))
    }

    /// Takes all that is left.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read.
    pub fn rest(&mut self) -> Result<Vec<u8>> {
        memory::read_to_end(self.path, &mut self.reader)
    }

    /// Reads a file that this one names, at most the first `most` bytes of it.
    ///
    /// # Errors
    /// As [`Input::open_file`].
    pub(in crate::io) fn read_beside(&mut self, path: &Path, most: u64) -> Result<Vec<u8>> {
        let mut other = Input::open_start(path, most)?;
        let bytes = other.rest()?;
        self.beside.push(other.finish()?.file);
        Ok(bytes)
    }

    /// Remembers something that the file's user should hear of.
    pub(in crate::io) fn remark(&mut self, text: String) {
        self.remarks.push(text);
    }

    /// Reads what is left, and says what was read.
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read.
    pub fn finish(mut self) -> Result<FilesRead> {
        let refused = |e| Error::io(self.path, "read", e);
        io::copy(&mut self.reader, &mut io::sink()).map_err(refused)?;
        let Hashed { length, hash, .. } = self.reader.into_inner();
        let file = FileRead { path: self.path.to_owned(), length, hash };
        let file = self.packed.unwrap_or(file);
        Ok(FilesRead { file, beside: self.beside, remarks: self.remarks })
    }
}

impl Read for Input<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.reader.read(bytes)
    }

    fn read_exact(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.reader.read_exact(bytes)
    }
}

impl BufRead for Input<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.reader.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.reader.consume(count);
    }
}

/// How to go on where a pipe cannot be read.
const HELP_FOR_PIPES: &str = "write what comes through it to a file, and name that";

#[cfg(unix)]
fn is_pipe(file_type: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&file_type)
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

/// Names what a path leads to when it is no file, and how to go on.
fn kind_of(file_type: FileType) -> (&'static str, &'static str) {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_socket(&file_type) {
        return ("socket", "name a file");
    }
    if is_pipe(file_type) {
        ("pipe", HELP_FOR_PIPES)
    } else if file_type.is_dir() {
        ("folder", "name a file in it")
    } else {
        ("device", "name a file")
    }
}

fn no_file(path: &Path, file_type: FileType) -> Error {
    let (kind, help) = kind_of(file_type);
    InputError::new(path, format!("this is a {kind}, not a file")).help(help).into()
}

/// Says of a gzip file that cannot be unpacked what is wrong with it.
fn damaged(path: &Path, error: Error) -> Error {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    match error {
        Error::Io { source, .. }
            if matches!(source.kind(), InvalidData | InvalidInput | UnexpectedEof) =>
        {
            let message = format!("this gzip file cannot be unpacked: {source}");
            let help = "the file is cut short or damaged; pack it again";
            InputError::new(path, message).help(help).into()
        }
        other => other,
    }
}

/// Says what was read: a file, and the files that it names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilesRead {
    /// The file itself.
    pub file: FileRead,
    /// The files that it names, as the buffers of a glTF file.
    pub beside: Vec<FileRead>,
    /// What was passed over though it looks as if it were meant, a sentence each.
    pub remarks: Vec<String>,
}

/// Says what was read of a file. Displayed as `120 bytes, fnv1a64:85944171f73967e8`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileRead {
    path: PathBuf,
    length: u64,
    hash: SourceHash,
}

impl FileRead {
    /// Returns the path by which the file was found.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names the file by its name and content.
    pub fn source(&self) -> Source {
        Source::of_file(&self.path, self.hash)
    }
}

impl fmt::Display for FileRead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes, {}", self.length, self.hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn error_of(opened: Result<Input>) -> String {
        opened.err().expect("refused").to_string()
    }

    #[test]
    fn what_is_no_file_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path();
        assert!(
            error_of(Input::open(path)).contains(": this is a folder, not a file\n  help: name")
        );
        let missing = path.join("missing");
        let missing = error_of(Input::open(&missing));
        assert!(missing.contains("missing: cannot read: "), "{missing}");
        #[cfg(unix)]
        for device in ["/dev/null", "/dev/zero"] {
            let error = error_of(Input::open(Path::new(device)));
            assert!(error.contains("this is a device, not a file"), "{error}");
        }
    }

    #[test]
    fn all_bytes_count_however_few_were_asked_for() {
        let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i % 251) as u8).collect();
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bin");
        fs::write(&path, &bytes).expect("written");
        let expected = format!("200000 bytes, {}", SourceHash::of(&bytes));
        for taken in [0, 1, 65_536, 70_000, 200_000] {
            let mut input = Input::open(&path).expect("a file");
            assert_eq!((input.length(), input.ahead().expect("readable").len()), (200_000, BUFFER));
            let mut start = vec![0; taken];
            input.read_exact(&mut start).expect("long enough");
            assert_eq!(start, bytes[..taken]);
            let read = input.finish().expect("readable").file;
            assert_eq!(read.to_string(), expected, "{taken}");
            assert_eq!(read.source(), Source::new(Path::new("a.bin"), &bytes));
        }
        let mut input = Input::of_bytes(Path::new("a.bin"), &bytes);
        assert_eq!(input.rest().expect("there"), bytes);
        assert_eq!(input.finish().expect("there").file.to_string(), expected);
    }

    #[test]
    fn of_a_file_beside_what_is_read_counts() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("b.bin");
        fs::write(&path, "0123456789").expect("written");
        let mut input = Input::of_bytes(Path::new("a"), b"");
        assert_eq!(input.read_beside(&path, 4).expect("readable"), b"0123");
        let beside = input.finish().expect("readable").beside;
        let expected = format!("4 bytes, {}", SourceHash::of(b"0123"));
        assert_eq!(beside.iter().map(ToString::to_string).collect::<Vec<_>>(), [expected]);
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(bytes).expect("into memory");
        packer.finish().expect("into memory")
    }

    #[test]
    fn packed_file_is_read_as_what_it_holds_and_known_as_what_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj.GZ");
        let content: Vec<u8> = (0..200_000_u32).map(|i| (i % 251) as u8).collect();
        // gzip files stand one behind the other, too.
        let file = [packed(&content[..70_000]), packed(&content[70_000..])].concat();
        fs::write(&path, &file).expect("written");
        for input in [Input::open(&path), Input::open_file(&path)] {
            let mut input = input.expect("unpacked");
            assert_eq!((input.length(), input.name()), (200_000, Path::new("a.obj")));
            assert_eq!((input.path(), input.rest().expect("all")), (&*path, content.clone()));
            let read = input.finish().expect("read").file;
            assert_eq!(
                read.to_string(),
                format!("{} bytes, {}", file.len(), SourceHash::of(&file))
            );
        }
        // What is beside another file is read as it is, and a name alone packs nothing.
        let mut other = Input::of_bytes(Path::new("b.obj.gz"), b"");
        assert_eq!(other.read_beside(&path, 4).expect("readable"), file[..4]);
        assert_eq!(other.name(), Path::new("b.obj.gz"));
    }

    #[test]
    fn packed_file_that_is_damaged_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.gz");
        let whole = packed(&[7; 5000]);
        let mut changed = whole.clone();
        let end = whole.len();
        changed[end - 5] ^= 1;
        for bytes in [&whole[..end - 1], &whole[..12], &changed, &[&whole[..], b"more"].concat()] {
            fs::write(&path, bytes).expect("written");
            let error = error_of(Input::open(&path));
            assert!(error.contains("a.gz: this gzip file cannot be unpacked: "), "{error}");
            assert!(error.contains("\n  help: the file is cut short or damaged"), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn pipe_is_read_where_it_may_be_and_never_waited_for_elsewhere() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&path).status().expect("mkfifo");
        assert!(made.success());
        let error = error_of(Input::open_file(&path));
        assert!(error.contains("this is a pipe, not a file\n  help: write what"), "{error}");
        let bytes = vec![b'x'; 150_000];
        let read = std::thread::scope(|scope| {
            scope.spawn(|| fs::write(&path, &bytes).expect("read by the other"));
            let mut input = Input::open(&path).expect("a pipe");
            assert_eq!((input.length(), input.rest().expect("all")), (150_000, bytes.clone()));
            input.finish().expect("read")
        });
        assert_eq!(read.file.to_string(), format!("150000 bytes, {}", SourceHash::of(&bytes)));
    }
}
