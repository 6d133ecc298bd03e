//! Internal loads on the pieces of the drawn lines, from those at the places where a model tells them.

use super::grid::Field;

/// A place where internal loads are told.
#[derive(Clone, Debug)]
pub struct Place {
    /// Its name: that of the channels `NAME.F` and `NAME.M`.
    pub name: String,
    /// Index of the line that it is on; places on lines that are not there are left out.
    pub line: usize,
    /// Fraction of the length of the line.
    pub fraction: f64,
}

/// Where internal loads are told along the lines that are drawn.
#[derive(Clone, Debug, Default)]
pub struct Along {
    /// The places.
    pub places: Vec<Place>,
    /// Ends of the elements of every line as fractions of its length, from 0 to 1.
    pub knots: Vec<Vec<f64>>,
}

/// Which places every piece of the lines takes its internal loads from.
#[derive(Clone, Debug, Default)]
pub(super) struct Sections {
    /// Places with their weights, piece after piece along one line after the other; none: nothing is known there.
    pieces: Vec<Vec<(usize, f64)>>,
    /// Names of the places.
    names: Vec<String>,
}

impl Sections {
    /// For lines through nodes at `positions` - (n x 3), each along a member, in their order.
    ///
    /// A piece that holds places has the mean of theirs; one between two places of its member what is linear between these.
    pub(super) fn new(positions: &[f64], lines: &[Vec<u32>], along: &Along) -> Self {
        let all = &along.places;
        if all.is_empty() {
            return Self::default();
        }
        let pieces = lines.iter().enumerate().flat_map(|(index, line)| {
            let own = all.iter().enumerate().filter(|(_, place)| place.line == index);
            let mut places: Vec<(f64, usize)> = own.map(|(k, place)| (place.fraction, k)).collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            let knots = along.knots.get(index).map_or(&[][..], |knots| knots);
            let ends = fractions(positions, line, knots);
            let last = ends.len().saturating_sub(2);
            let pairs: Vec<(f64, f64)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
            pairs
                .into_iter()
                .enumerate()
                .map(|(k, (from, to))| piece(&places, from, to, k == last))
                .collect::<Vec<_>>()
        });
        Self { pieces: pieces.collect(), names: all.iter().map(|place| place.name.clone()).collect() }
    }

    /// Whether nothing is known anywhere.
    pub(super) fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Names of the places.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// A vector on every piece, from those at the places.
    pub(super) fn field(&self, name: &str, at: impl Fn(usize) -> [f64; 3]) -> Field {
        let value = |places: &Vec<(usize, f64)>| match places.as_slice() {
            [] => [f64::NAN; 3],
            places => places.iter().fold([0.0; 3], |sum, (place, weight)| {
                let x = at(*place);
                [0, 1, 2].map(|k| sum[k] + weight * x[k])
            }),
        };
        Field { name: name.to_owned(), values: self.pieces.iter().flat_map(value).collect() }
    }
}

/// Fractions of the length of a line at its nodes: those of the elements where every node is drawn, with one in their middles or none;
/// else by the distances of the nodes.
fn fractions(positions: &[f64], line: &[u32], knots: &[f64]) -> Vec<f64> {
    if line.len() == knots.len() {
        return knots.to_vec();
    }
    if line.len() + 1 == 2 * knots.len() {
        let middles = knots.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]);
        return middles.chain(knots.last().copied()).collect();
    }
    let at = |node: u32| &positions[3 * node as usize..3 * node as usize + 3];
    let distance =
        |a: u32, b: u32| at(a).iter().zip(at(b)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let mut ends = vec![0.0];
    for pair in line.windows(2) {
        ends.push(ends[ends.len() - 1] + distance(pair[0], pair[1]));
    }
    let length = ends.last().copied().filter(|length| *length > 0.0).unwrap_or(1.0);
    ends.iter().map(|end| end / length).collect()
}

/// Places and weights for the piece between two fractions; a place at a node belongs to the piece after it.
fn piece(places: &[(f64, usize)], from: f64, to: f64, is_last: bool) -> Vec<(usize, f64)> {
    // Fractions by the straight lines of a drawing are those of a bent member to some digits.
    let slack = 1e-3 * (to - from);
    let inside = |x: f64| x >= from - slack && (x < to - slack || is_last && x <= to + slack);
    let own: Vec<usize> = places.iter().filter(|place| inside(place.0)).map(|place| place.1).collect();
    if !own.is_empty() {
        let weight = 1.0 / own.len() as f64;
        return own.into_iter().map(|place| (place, weight)).collect();
    }
    let middle = 0.5 * (from + to);
    let after = places.partition_point(|place| place.0 <= middle);
    match (after.checked_sub(1).and_then(|k| places.get(k)), places.get(after)) {
        (Some((a, before)), Some((b, next))) => {
            let share = (middle - a) / (b - a);
            vec![(*before, 1.0 - share), (*next, share)]
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_take_what_is_on_them_or_on_both_sides() {
        let places = [(0.0, 7), (0.5, 3), (0.52, 4)];
        let of = |from, to, last| piece(&places, from, to, last);
        assert_eq!(of(0.0, 0.1, false), [(7, 1.0)]);
        // At the node between two pieces: the one after it.
        assert_eq!(of(0.5, 0.6, false), [(3, 0.5), (4, 0.5)]);
        let between = of(0.4, 0.5, false);
        assert_eq!((between[0].0, between[1].0), (7, 3));
        assert!((between[1].1 - 0.9).abs() < 1e-12 && (between[0].1 - 0.1).abs() < 1e-12);
        assert!(of(0.6, 0.7, false).is_empty() && of(0.9, 1.0, true).is_empty());
        assert_eq!(piece(&[(1.0, 2)], 0.9, 1.0, true), [(2, 1.0)]);
        assert_eq!(
            fractions(&[0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 3.0, 1.0, 0.0], &[0, 1, 2], &[]),
            [0.0, 0.75, 1.0]
        );
        assert_eq!(fractions(&[], &[0, 1, 2], &[0.0, 1.0]), [0.0, 0.5, 1.0]);
        assert_eq!(fractions(&[], &[0, 1, 2], &[0.0, 0.3, 1.0]), [0.0, 0.3, 1.0]);
    }
}
