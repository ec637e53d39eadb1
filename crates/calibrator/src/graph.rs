//! Who is joined with whom: the strongest spanning forest of a small graph, and its islands.

/// Two nodes and how strongly they are joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    pub nodes: [usize; 2],
    pub strength: f64,
}

/// For each node its island's number; islands are numbered by their first node.
pub(crate) fn islands(n: usize, edges: &[Edge]) -> Vec<usize> {
    let mut root: Vec<usize> = (0..n).collect();
    for edge in edges {
        let [a, b] = edge.nodes.map(|node| find(&root, node));
        root[a.max(b)] = a.min(b);
    }
    (0..n).map(|node| find(&root, node)).collect()
}

/// The edges of the strongest forest, as indices into `edges` (J. Kruskal, 1956); equal strengths in the order given.
pub(crate) fn spanning_forest(n: usize, edges: &[Edge]) -> Vec<usize> {
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
pub(crate) fn walk(edges: &[Edge], forest: &[usize], start: usize) -> Vec<(usize, usize, usize)> {
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
        assert_eq!(islands(5, &edges), [0, 0, 0, 3, 3]);
    }

    #[test]
    fn a_walk_reaches_its_island_only() {
        let edges = [edge(0, 1, 1.0), edge(1, 2, 5.0), edge(3, 4, 1.0)];
        let forest = spanning_forest(5, &edges);
        assert_eq!(walk(&edges, &forest, 2), [(1, 2, 1), (0, 1, 0)]);
    }
}
