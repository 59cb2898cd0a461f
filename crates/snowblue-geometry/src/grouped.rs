//! Items in groups by number, in one list: a counting sort.

/// Items in groups.
pub struct Grouped<T> {
    /// Where each group begins, and the end of the last.
    starts: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy + Default> Grouped<T> {
    /// Sorts items by their group, below `groups`, in the order in which they come.
    pub fn new(groups: usize, items: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0; groups + 1];
        items.clone().for_each(|(group, _)| starts[group as usize + 1] += 1);
        for group in 0..groups {
            starts[group + 1] += starts[group];
        }
        let (mut next, mut sorted) = (starts.clone(), vec![T::default(); starts[groups]]);
        for (group, item) in items {
            sorted[next[group as usize]] = item;
            next[group as usize] += 1;
        }
        Self { starts, items: sorted }
    }

    /// The items of a group.
    pub fn group(&self, group: usize) -> &[T] {
        &self.items[self.starts[group]..self.starts[group + 1]]
    }

    /// Calls `visit` for each group, which it may change.
    pub fn visit_mut(&mut self, mut visit: impl FnMut(&mut [T])) {
        for ends in self.starts.windows(2) {
            visit(&mut self.items[ends[0]..ends[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_keep_their_order_in_their_groups() {
        let mut grouped = Grouped::new(4, [(2, 'a'), (0, 'b'), (2, 'c'), (3, 'd')].into_iter());
        assert_eq!(
            [0, 1, 2, 3].map(|group| grouped.group(group).to_vec()),
            [vec!['b'], vec![], vec!['a', 'c'], vec!['d']]
        );
        let mut sizes = Vec::new();
        grouped.visit_mut(|group| sizes.push(group.len()));
        assert_eq!(sizes, [1, 0, 2, 1]);
    }
}
