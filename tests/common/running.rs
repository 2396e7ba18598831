//! The tool under way: what tests that kill, interrupt or watch it have in common.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::NamedTempFile;

use super::desk::Said;

/// The time between two looks at a run.
const A_MOMENT: Duration = Duration::from_millis(2);

/// A run under way, which is killed when it is dropped, as by a test that fails.
pub struct Running {
    child: Child,
    out: NamedTempFile,
    err: NamedTempFile,
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    /// Starts a command; what it says is kept outside of its folder.
    pub fn start(command: &mut Command) -> Self {
        let [out, err] = [(); 2].map(|()| NamedTempFile::new().expect("a file"));
        let [to_out, to_err] = [&out, &err].map(|file| file.reopen().expect("a file"));
        let command = command.stdin(Stdio::null()).stdout(to_out).stderr(to_err);
        Self { child: command.spawn().expect("it starts"), out, err }
    }

    /// Sends a signal.
    pub fn send(&self, signal: &str) {
        let kill = Command::new("kill").args([signal, &self.child.id().to_string()]).status();
        assert!(kill.expect("kill is there").success(), "the run had ended: {}", self.err());
    }

    /// Waits for what must come, however slow the machine. Whether it came before the run ended.
    #[must_use]
    pub fn wait_for(&mut self, mut seen: impl FnMut(&Self) -> bool) -> bool {
        let started = Instant::now();
        while !seen(self) {
            if self.child.try_wait().expect("a child").is_some() {
                return false;
            }
            assert!(started.elapsed() < Duration::from_secs(120), "it does not come");
            sleep(A_MOMENT);
        }
        true
    }

    /// Returns what it has said on stderr.
    pub fn err(&self) -> String {
        fs::read_to_string(self.err.path()).expect("UTF-8")
    }

    /// Waits for the end.
    pub fn end(&mut self) -> Said {
        let started = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                let out = fs::read_to_string(self.out.path()).expect("UTF-8");
                return Said { code: status.code().unwrap_or(-1), out, err: self.err() };
            }
            assert!(started.elapsed() < Duration::from_secs(60), "still running: {}", self.err());
            sleep(A_MOMENT);
        }
    }
}
