//! A small graph of relative poses, its connected components (islands) and its maximum spanning forest.

use sextant_geometry::Pose;

/// Two nodes and the weight of their connection.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    nodes: [usize; 2],
    strength: f64,
}

/// A graph of relative poses between pairs of tags of an object or of cameras of a rig.
#[derive(Clone, Debug, Default)]
pub(crate) struct PoseGraph {
    n: usize,
    edges: Vec<Edge>,
    /// `first_from_second` of each edge.
    poses: Vec<Pose>,
}

impl PoseGraph {
    /// A graph of `n` nodes without edges.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            n,
            ..Self::default()
        }
    }

    /// Connects two nodes; edges of greater strength are preferred where several paths lead to a node.
    pub(crate) fn join(&mut self, nodes: [usize; 2], strength: f64, first_from_second: Pose) {
        self.edges.push(Edge { nodes, strength });
        self.poses.push(first_from_second);
    }

    /// Each node's island, numbered by its first node.
    pub(crate) fn islands(&self) -> Vec<usize> {
        islands(self.n, self.edges.iter().map(|edge| edge.nodes))
    }

    /// The pose of every node of `root`'s island in the root's frame.
    pub(crate) fn placed(&self, root: usize) -> Vec<Option<Pose>> {
        let forest = spanning_forest(self.n, &self.edges);
        let mut placed = vec![None; self.n];
        placed[root] = Some(Pose::identity());
        for (edge, from, to) in walk(&self.edges, &forest, root) {
            let pose = self.poses[edge];
            let step = if self.edges[edge].nodes[0] == from {
                pose
            } else {
                pose.inverse()
            };
            placed[to] = placed[from].map(|at: Pose| at * step);
        }
        placed
    }

    /// Sum of the strengths of the edges of a node.
    pub(crate) fn strength(&self, node: usize) -> f64 {
        let own = self.edges.iter().filter(|edge| edge.nodes.contains(&node));
        own.map(|edge| edge.strength).sum()
    }
}

/// For each node its island's number; islands are numbered by their first node.
pub(crate) fn islands(n: usize, joined: impl IntoIterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut root: Vec<usize> = (0..n).collect();
    for nodes in joined {
        let [a, b] = nodes.map(|node| find(&root, node));
        root[a.max(b)] = a.min(b);
    }
    (0..n).map(|node| find(&root, node)).collect()
}

/// The edges of the strongest forest, as indices into `edges` (J. Kruskal, 1956); equal strengths in the order given.
fn spanning_forest(n: usize, edges: &[Edge]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by(|&a, &b| edges[b].strength.total_cmp(&edges[a].strength));
    let mut root: Vec<usize> = (0..n).collect();
    order.retain(|&at| {
        let [a, b] = edges[at].nodes.map(|node| find(&root, node));
        root[a.max(b)] = a.min(b);
        a != b
    });
    order
}

/// Steps (edge, from, to) that reach every node of `start`'s island along a forest, nearest first.
fn walk(edges: &[Edge], forest: &[usize], start: usize) -> Vec<(usize, usize, usize)> {
    let mut steps: Vec<(usize, usize, usize)> = Vec::new();
    let mut reached = vec![start];
    let mut at = 0;
    while let Some(&from) = reached.get(at) {
        for &index in forest {
            let [a, b] = edges[index].nodes;
            let to = match from {
                _ if a == from => b,
                _ if b == from => a,
                _ => continue,
            };
            if !reached.contains(&to) {
                reached.push(to);
                steps.push((index, from, to));
            }
        }
        at += 1;
    }
    steps
}

fn find(root: &[usize], mut node: usize) -> usize {
    while root[node] != node {
        node = root[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(a: usize, b: usize, strength: f64) -> Edge {
        Edge {
            nodes: [a, b],
            strength,
        }
    }

    #[test]
    fn the_strongest_edges_make_the_forest() {
        let edges = [
            edge(0, 1, 1.0),
            edge(1, 2, 5.0),
            edge(0, 2, 3.0),
            edge(3, 4, 1.0),
        ];
        assert_eq!(spanning_forest(5, &edges), [1, 2, 3]);
        let joined = edges.iter().map(|edge| edge.nodes);
        assert_eq!(islands(5, joined), [0, 0, 0, 3, 3]);
    }

    #[test]
    fn poses_chain_along_the_strongest_edges_in_either_direction() {
        let along = |x: f64| Pose::translation(x, 0.0, 0.0);
        let mut graph = PoseGraph::new(4);
        graph.join([0, 1], 5.0, along(1.0));
        graph.join([1, 2], 5.0, along(2.0));
        graph.join([0, 2], 1.0, along(9.0));
        let x = |pose: &Option<Pose>| pose.map(|pose| pose.translation.x);
        let placed: Vec<Option<f64>> = graph.placed(2).iter().map(x).collect();
        assert_eq!(placed, [Some(-3.0), Some(-2.0), Some(0.0), None]);
        assert_eq!(graph.islands(), [0, 0, 0, 3]);
        assert_eq!(graph.strength(2), 6.0);
    }

    #[test]
    fn a_walk_reaches_its_island_only() {
        let edges = [edge(0, 1, 1.0), edge(1, 2, 5.0), edge(3, 4, 1.0)];
        let forest = spanning_forest(5, &edges);
        assert_eq!(walk(&edges, &forest, 2), [(1, 2, 1), (0, 1, 0)]);
    }
}
