//! Many things to do, one after the other on each thread: no more of them exist at once than there
//! are threads.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Does `job` for each item, several at once, and gives the results in the order of the items;
/// `None` for those left undone.
///
/// As many items are under way as the pool has threads, each on a thread of its own that lends its
/// inner parallel work to the pool: memory is bounded by the largest few, and a result depends on
/// its item alone. `watch` sees each result as it comes, in any order, with the number done; it
/// ends the work by `Break`, after what is under way.
///
/// # Panics
/// When `job` does: a programmer's error.
pub fn batch<T: Send, R: Send>(
    items: Vec<T>,
    job: impl Fn(T) -> R + Sync,
    watch: impl Fn(&R, usize) -> ControlFlow<()> + Sync,
) -> Vec<Option<R>> {
    let workers = rayon::current_num_threads().min(items.len());
    let results = Mutex::new(items.iter().map(|_| None).collect::<Vec<Option<R>>>());
    let queue = Mutex::new(items.into_iter().enumerate());
    let (ended, done) = (AtomicBool::new(false), AtomicUsize::new(0));
    let work = || {
        while !ended.load(Ordering::Relaxed) {
            let Some((i, item)) = queue.lock().ok().and_then(|mut queue| queue.next()) else {
                return;
            };
            let result = job(item);
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if watch(&result, count).is_break() {
                ended.store(true, Ordering::Relaxed);
            }
            if let Ok(mut results) = results.lock() {
                results[i] = Some(result);
            }
        }
    };
    // The present thread is one of them, and does all where no other can be started.
    std::thread::scope(|scope| {
        for _ in 1..workers {
            let _ = std::thread::Builder::new().spawn_scoped(scope, work);
        }
        work();
    });
    results.into_inner().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_to_do_is_done() {
        assert!(batch(Vec::<u8>::new(), |x| x, |_, _| ControlFlow::Continue(())).is_empty());
    }

    #[test]
    fn results_keep_the_order_and_all_are_seen() {
        let most = AtomicUsize::new(0);
        let watch = |_: &usize, done: usize| {
            most.fetch_max(done, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let squares = batch((0..100).collect(), |i: usize| i * i, watch);
        assert_eq!(squares, (0..100).map(|i| Some(i * i)).collect::<Vec<_>>());
        assert_eq!(most.into_inner(), 100);
    }

    #[test]
    fn a_break_leaves_the_rest_undone() {
        let results = batch((0..1000).collect(), |i: usize| i, |_, _| ControlFlow::Break(()));
        let done = results.iter().flatten().count();
        assert!(done >= 1 && done <= rayon::current_num_threads(), "{done}");
    }
}
