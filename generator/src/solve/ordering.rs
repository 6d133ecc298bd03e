//! Elimination order of the nodes: minimum degree on the elimination graph.
//!
//! Structures of beams are trees of chains with few loops. Minimum degree eats them from the tips inwards, so a tree has
//! no fill at all and cost and memory stay proportional to the number of nodes. Ties go to the lowest index, so the order
//! does not depend on anything but the pattern.

use std::collections::BTreeSet;

use crate::assembly::BlockPattern;

/// Elimination sequence and, per pivot, the later neighbours it meets.
#[derive(Clone, Debug)]
pub struct Elimination {
    /// Block row eliminated at each step.
    pub order: Vec<u32>,
    /// For each step, the still uneliminated neighbours (block rows), in the order of their own elimination.
    pub neighbours: Vec<Vec<u32>>,
}

/// Minimum-degree elimination of a symmetric pattern.
pub fn minimum_degree(pattern: &BlockPattern) -> Elimination {
    let n = pattern.n();
    let mut graph: Vec<BTreeSet<u32>> = (0..n)
        .map(|i| pattern.row(i).map(|(j, _)| j as u32).filter(|&j| j as usize != i).collect())
        .collect();
    let mut queue: BTreeSet<(usize, u32)> = (0..n).map(|i| (graph[i].len(), i as u32)).collect();
    let mut out = Elimination { order: Vec::with_capacity(n), neighbours: Vec::with_capacity(n) };
    while let Some((_, pivot)) = queue.pop_first() {
        let around: Vec<u32> = std::mem::take(&mut graph[pivot as usize]).into_iter().collect();
        for &i in &around {
            queue.remove(&(graph[i as usize].len(), i));
            graph[i as usize].remove(&pivot);
            graph[i as usize].extend(around.iter().copied().filter(|&j| j != i));
            queue.insert((graph[i as usize].len(), i));
        }
        out.order.push(pivot);
        out.neighbours.push(around);
    }
    let mut position = vec![0u32; n];
    for (step, &i) in out.order.iter().enumerate() {
        position[i as usize] = step as u32;
    }
    for list in &mut out.neighbours {
        list.sort_unstable_by_key(|&i| position[i as usize]);
    }
    out
}
