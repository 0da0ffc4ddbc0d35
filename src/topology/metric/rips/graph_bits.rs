//! The graph so far, as closed neighbourhoods: one row of bits a vertex.
//!
//! In: vertices that are joined.
//! Out: rows of bits.
//! Invariants: every vertex is its own neighbour. Rows are symmetric, and whole runs of `LANES` words.
//! Must not know: lengths.

/// Words that are treated at once.
pub const LANES: usize = 8;

/// Adjacency of a graph.
#[derive(Clone, Debug, Default)]
pub struct GraphBits {
    words: usize,
    rows: Vec<u64>,
}

impl GraphBits {
    /// A graph without edges.
    pub fn new(count: usize) -> Self {
        let words = count.div_ceil(64).next_multiple_of(LANES);
        let mut graph = Self { words, rows: vec![0; words * count] };
        graph.clear();
        graph
    }

    /// Removes all edges.
    pub fn clear(&mut self) {
        self.rows.fill(0);
        for vertex in 0..self.count() {
            self.set(vertex, vertex);
        }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.rows.capacity() * size_of::<u64>()
    }

    /// The number of vertices.
    pub fn count(&self) -> usize {
        self.rows.len().checked_div(self.words).unwrap_or(0)
    }

    /// Words of a row.
    #[inline]
    pub fn words(&self) -> usize {
        self.words
    }

    /// The closed neighbourhood of a vertex.
    #[inline]
    pub fn row(&self, vertex: u32) -> &[u64] {
        &self.rows[vertex as usize * self.words..][..self.words]
    }

    /// Whether two vertices are joined, or one.
    #[inline]
    pub fn has(&self, a: u32, b: u32) -> bool {
        self.rows[a as usize * self.words + b as usize / 64] >> (b % 64) & 1 != 0
    }

    /// Joins two vertices.
    #[inline]
    pub fn join(&mut self, a: u32, b: u32) {
        self.set(a as usize, b as usize);
        self.set(b as usize, a as usize);
    }

    #[inline]
    fn set(&mut self, a: usize, b: usize) {
        self.rows[a * self.words + b / 64] |= 1 << (b % 64);
    }
}

/// The first vertex of a set.
pub fn lowest(set: &[u64]) -> Option<u32> {
    let word = set.iter().position(|&bits| bits != 0)?;
    Some(word as u32 * 64 + set[word].trailing_zeros())
}

/// The vertex in the middle of a set of so many.
pub fn middle(set: &[u64], count: u32) -> Option<u32> {
    let mut before = count / 2;
    for (word, &bits) in set.iter().enumerate() {
        let here = bits.count_ones();
        if before < here {
            let rest = (0..before).fold(bits, |bits, _| bits & (bits - 1));
            return Some(word as u32 * 64 + rest.trailing_zeros());
        }
        before -= here;
    }
    None
}

/// Whether two sets have a vertex in common.
pub fn meet(one: &[u64], other: &[u64]) -> bool {
    one.iter().zip(other).fold(0, |any, (x, y)| any | x & y) != 0
}
