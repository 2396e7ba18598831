//! The tool as a user meets it: a process in a folder of its own, judged by its exit code, what it
//! says and what it writes.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::iter::Chain;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A folder to work in, and the words that every command begins with.
pub struct Desk {
    folder: TempDir,
    verb: Vec<&'static str>,
}

/// How a command ended, and what it said on stdout and stderr.
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// The words of a command: a line, cut at its spaces, or a list.
pub trait Words {
    fn words(&self) -> Vec<OsString>;
}

impl Desk {
    /// An empty folder.
    pub fn new() -> Self {
        Self::of(&[])
    }

    /// An empty folder for commands that begin with these words.
    pub fn of(verb: &[&'static str]) -> Self {
        Self { folder: tempfile::tempdir().expect("a folder"), verb: verb.to_vec() }
    }

    /// Puts a file there.
    pub fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        self.put(name, bytes);
        self
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect("written");
    }

    /// Puts a pipe there, which nobody writes to.
    #[cfg(unix)]
    pub fn put_pipe(&self, name: &str) {
        let made = Command::new("mkfifo").arg(self.path(name)).status();
        assert!(made.expect("mkfifo is there").success());
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).expect("UTF-8")
    }

    /// Everything in the folder; a folder in it has no bytes.
    pub fn content(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let entries = fs::read_dir(self.folder.path()).expect("readable");
        let paths = entries.map(|e| e.expect("readable").path());
        paths.map(|path| (path.clone(), fs::read(&path).unwrap_or_default())).collect()
    }

    pub fn command(&self, words: impl Words) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_harmolux"));
        command.current_dir(self.folder.path()).args(&self.verb).args(words.words());
        command
    }

    /// Starts a command whose end is not waited for.
    pub fn start(&self, words: impl Words) -> Child {
        let mut command = self.command(words);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("the tool starts")
    }

    pub fn run(&self, words: impl Words) -> Said {
        Said::of(&self.command(words).output().expect("the tool starts"))
    }

    /// Runs a command that must end with this code.
    pub fn ends(&self, code: i32, words: impl Words) -> Said {
        let line = words.words();
        let said = self.run(words);
        assert_eq!(said.code, code, "{line:?}: {}{}", said.out, said.err);
        said
    }

    /// Runs what must be done.
    pub fn done(&self, words: impl Words) -> Said {
        self.ends(0, words)
    }

    /// Runs what must end with this code, with `--json`.
    pub fn json_at(&self, code: i32, words: impl Words) -> Value {
        let mut words = words.words();
        words.push("--json".into());
        let said = self.ends(code, words);
        serde_json::from_str(&said.out).expect("valid JSON on stdout, and nothing else")
    }

    /// Runs what must be done, with `--json`.
    pub fn json(&self, words: impl Words) -> Value {
        self.json_at(0, words)
    }

    /// Runs what must be refused as bad input, in these words, without writing anything.
    pub fn refused(&self, words: impl Words, says: &[&str]) {
        let before = self.content();
        let said = self.ends(3, words);
        // A slow machine says first how far it is, as in `10.0 s  fitting a.obj`.
        let is_progress = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
        let first = said.err.lines().find(|line| !is_progress(line));
        assert!(first.is_some_and(|line| line.starts_with("error: ")), "{}", said.err);
        assert_says(&said.err, says);
        assert_eq!(said.out, "", "data for bad input");
        assert!(self.content() == before, "something was written: {:?}", self.content().keys());
    }
}

impl Said {
    pub fn of(output: &Output) -> Self {
        let [out, err] = [&output.stdout, &output.stderr]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        Self { code: output.status.code().unwrap_or(-1), out, err }
    }

    /// Returns the exit code, and both texts as one.
    pub fn all(self) -> (i32, String) {
        (self.code, self.out + &self.err)
    }
}

impl Words for str {
    fn words(&self) -> Vec<OsString> {
        self.split_whitespace().map(Into::into).collect()
    }
}

impl Words for String {
    fn words(&self) -> Vec<OsString> {
        self.as_str().words()
    }
}

impl<S: AsRef<OsStr>> Words for [S] {
    fn words(&self) -> Vec<OsString> {
        self.iter().map(Into::into).collect()
    }
}

impl<S: AsRef<OsStr>, const N: usize> Words for [S; N] {
    fn words(&self) -> Vec<OsString> {
        self.as_slice().words()
    }
}

impl<S: AsRef<OsStr>> Words for Vec<S> {
    fn words(&self) -> Vec<OsString> {
        self.as_slice().words()
    }
}

impl<A, B> Words for Chain<A, B>
where
    Self: Iterator + Clone,
    <Self as Iterator>::Item: AsRef<OsStr>,
{
    fn words(&self) -> Vec<OsString> {
        self.clone().map(|word| word.as_ref().to_owned()).collect()
    }
}

impl<T: Words + ?Sized> Words for &T {
    fn words(&self) -> Vec<OsString> {
        (*self).words()
    }
}

/// Asks for each of the words in a text.
pub fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is missing in:\n{text}");
    }
}

/// Returns a number of a report.
pub fn number(report: &Value, name: &str) -> f64 {
    report[name].as_f64().unwrap_or_else(|| panic!("{name} is no number in {report}"))
}

/// Returns the path of a file of the repository.
pub fn repository(path: &str) -> String {
    format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Whether this process ignores a signal, and so do those it starts: as a script's background job
/// does with SIGINT.
#[cfg(unix)]
pub fn is_ignored(signal: u32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Returns the signal that asks a run to end: SIGINT, or SIGTERM where that is ignored.
#[cfg(unix)]
pub fn interrupt() -> &'static str {
    if is_ignored(2) { "-TERM" } else { "-INT" }
}
