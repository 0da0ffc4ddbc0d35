//! A union-find of vertices.
//!
//! In: pairs.
//! Out: which of them join two components.
//! Must not know: lengths.

/// Components of a graph.
#[derive(Clone, Debug, Default)]
pub struct Forest(Vec<u32>);

impl Forest {
    /// So many components of one vertex each.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The vertex that names a component.
    pub fn root(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            let above = self.0[self.0[vertex as usize] as usize];
            self.0[vertex as usize] = above;
            vertex = above;
        }
        vertex
    }

    /// Joins two vertices. Whether that joined two components.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a as usize] = b;
        a != b
    }
}
