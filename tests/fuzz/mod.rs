//! Runs one target on case after case until its time is up. `ROM_FUZZ_SECONDS` says how long (12 s); a failure names its case, which
//! `ROM_FUZZ_CASE` runs alone.

use std::time::{Duration, Instant};

/// Longest time one case may take: far above any sound one in a debug build on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// xorshift64*: enough to choose mutations.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn case(number: u64) -> Self {
        // Neighbouring numbers give unrelated sequences (the mixer of splitmix64).
        let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((z ^ (z >> 31)) | 1)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    pub(crate) fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

/// Runs cases until the time is up, and says how many there were.
pub(crate) fn fuzz(target: &str, mut run: impl FnMut(&mut Random)) {
    let variable = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u64>().ok());
    if let Some(case) = variable("ROM_FUZZ_CASE") {
        return run(&mut Random::case(case));
    }
    let budget = Duration::from_secs(variable("ROM_FUZZ_SECONDS").unwrap_or(12));
    let start = Instant::now();
    let mut cases = 0;
    while start.elapsed() < budget {
        let begun = Instant::now();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(&mut Random::case(cases))));
        if let Err(panic) = result {
            eprintln!("{target}: case {cases} fails; ROM_FUZZ_CASE={cases} runs it alone");
            std::panic::resume_unwind(panic);
        }
        assert!(begun.elapsed() < PATIENCE, "{target}: case {cases} takes {:?}", begun.elapsed());
        cases += 1;
    }
    println!("{target}: {cases} cases in {:.0?}", start.elapsed());
    assert!(cases > 20, "{target}: only {cases} cases in {budget:?}");
}
