//! Numbers by which copies of what does not change are known to be the same without a look at them.

use core::sync::atomic::{AtomicUsize, Ordering};

/// Of something and its copies, and of nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity(Option<usize>);

impl Identity {
    /// A new one. After the last there is none: then nothing is known to be the same.
    pub(crate) fn new() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        Identity(NEXT.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_add(1)).ok())
    }

    /// That of nothing.
    pub(crate) const NONE: Self = Identity(None);

    pub(crate) fn is(self, other: Self) -> bool {
        self.0.is_some() && self.0 == other.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_copies_are_the_same() {
        let (a, b) = (Identity::new(), Identity::new());
        let copy = a;
        assert!(a.is(copy) && !a.is(b) && !a.is(Identity::NONE) && !Identity::NONE.is(Identity::NONE));
    }
}
