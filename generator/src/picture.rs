//! Which nodes a drawing of the structure needs.

use crate::mesh::Mesh;

/// Nodes enough for a drawing on a screen.
pub const NODES: usize = 240;

/// Chosen nodes and the lines between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outline {
    /// Chosen nodes, ascending.
    pub nodes: Vec<usize>,
    /// Along each line, indices into `nodes`.
    pub lines: Vec<Vec<u32>>,
}

impl Outline {
    /// Every node of a mesh.
    pub fn whole(mesh: &Mesh) -> Self {
        Self::thinned(mesh, usize::MAX)
    }

    /// About `limit` nodes of a mesh, evenly along its members. The ends of the members and the nodes of named points are always
    /// among them.
    pub fn thinned(mesh: &Mesh, limit: usize) -> Self {
        let mut kept = vec![false; mesh.nodes.len()];
        kept[mesh.reference] = true;
        let carrying = mesh.points.iter().flat_map(|point| mesh.nodes_of(point.place));
        carrying.for_each(|node| kept[node] = true);
        let lines: Vec<&[usize]> = mesh.members.iter().map(|member| member.nodes.as_slice()).collect();
        thin(&lines, &kept, limit)
    }
}

/// About `limit` of the nodes along `lines`, evenly; their ends and the nodes that are `kept` are always among them.
pub fn thin(lines: &[&[usize]], kept: &[bool], limit: usize) -> Outline {
    let total: usize = lines.iter().map(|line| line.len()).sum();
    let chosen: Vec<Vec<usize>> = lines.iter().map(|line| thinned_line(line, kept, total, limit)).collect();
    let mut nodes: Vec<usize> = chosen.iter().flatten().copied().collect();
    nodes.extend((0..kept.len()).filter(|&node| kept[node]));
    nodes.sort_unstable();
    nodes.dedup();
    let index = |node: &usize| nodes.binary_search(node).unwrap_or(0) as u32;
    let lines = chosen.iter().map(|line| line.iter().map(index).collect()).collect();
    Outline { nodes, lines }
}

/// Of `n` nodes of a line, its share of `limit` out of `total`, the ends and those kept anyway.
fn thinned_line(line: &[usize], kept: &[bool], total: usize, limit: usize) -> Vec<usize> {
    let n = line.len();
    if total <= limit || n <= 2 {
        return line.to_vec();
    }
    let intervals = ((n as f64 * limit as f64 / total as f64).round() as usize).clamp(1, n - 1);
    let mut places: Vec<usize> = (0..=intervals).map(|k| k * (n - 1) / intervals).collect();
    places.extend((0..n).filter(|&k| kept[line[k]]));
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|k| line[k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_structures::fmb;

    #[test]
    fn a_coarse_mesh_is_drawn_whole() {
        let mesh = fmb(1.0, 12, 2);
        let outline = Outline::thinned(&mesh, NODES);
        assert_eq!(outline, Outline::whole(&mesh));
        assert_eq!(outline.nodes, (0..mesh.nodes.len()).collect::<Vec<_>>());
        let drawn: Vec<usize> = outline.lines[1].iter().map(|&i| outline.nodes[i as usize]).collect();
        assert_eq!(drawn, mesh.members[1].nodes);
    }

    /// The drawing of a fine mesh is no larger, joins its members where they meet and misses no member end or named point.
    #[test]
    fn a_fine_mesh_keeps_its_ends_and_points() {
        let mesh = fmb(1.0, 6_000, 2);
        let outline = Outline::thinned(&mesh, NODES);
        assert!(outline.nodes.len() < NODES + 2 * mesh.members.len() + mesh.points.len());
        for (member, line) in mesh.members.iter().zip(&outline.lines) {
            let drawn: Vec<usize> = line.iter().map(|&i| outline.nodes[i as usize]).collect();
            assert_eq!((drawn.first(), drawn.last()), (member.nodes.first(), member.nodes.last()));
            // Even: no gap is much longer than its share.
            let place = |node: &usize| member.nodes.iter().position(|n| n == node).unwrap();
            let gaps = drawn.windows(2).map(|pair| place(&pair[1]) - place(&pair[0]));
            assert!(gaps.max().unwrap() <= 2 * mesh.nodes.len() / NODES);
        }
        for point in &mesh.points {
            let nodes = mesh.nodes_of(point.place);
            assert!(nodes.iter().all(|n| outline.nodes.binary_search(n).is_ok()), "{}", point.name);
        }
    }
}
