//! Independent work on all cores.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// `work` on every item, results in the order of the items. Items are taken in order, so the longest should come first.
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let slots: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::new(None)).collect();
    let worker = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(item), Some(slot)) = (items.get(i), slots.get(i)) else { break };
            let result = work(item);
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    // A panic in a thread goes on in the caller when the scope ends, so that every slot is filled after it.
    thread::scope(|scope| (0..cores.min(items.len())).for_each(|_| _ = scope.spawn(worker)));
    slots.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_are_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..200).collect();
        let slow_first = |n: &u64| {
            std::thread::sleep(std::time::Duration::from_micros(200 - n));
            n * n
        };
        assert_eq!(super::map(&items, slow_first), items.iter().map(|n| n * n).collect::<Vec<_>>());
        assert!(super::map(&[], slow_first).is_empty());
    }
}
