//! Ctrl-C and the like: the first asks the run to end and save, the second ends at once.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens from now on.
pub(crate) fn listen() {
    let heard = || {
        if ASKED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        super::say::note("interrupted: saving what there is; again to end at once");
    };
    if ctrlc::set_handler(heard).is_err() {
        super::say::warning("interrupts cannot be caught here: Ctrl-C will lose the run");
    }
}

/// Whether the run was asked to end.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}
