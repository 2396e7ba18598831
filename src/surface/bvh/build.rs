//! From boxes to nodes of eight: obvhs builds a binary tree, which is cut into wide nodes and
//! leaves at the least cost.
//!
//! The cost of a wide tree is the expected work of a ray: the area of every node and leaf times
//! what it costs to open it (surface area heuristic). The cut that makes it least follows
//! bottom-up: with C(n, i) the least cost of the boxes below binary node n as at most i wide
//! children (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", 2017),
//!     C(n, 1) = min(cost of n as a leaf,
//!                   area(n) NODE + min over k of C(left, k) + C(right, 8 - k)),
//!     C(n, i) = min(C(n, i - 1), min over k of C(left, k) + C(right, i - k)).

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;

use super::node::{Child, Node, SmallBox, WIDTH};

/// What a tree is cut into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaves {
    /// The most boxes a leaf holds.
    pub(super) most: u32,
    /// What a leaf costs, whatever it holds.
    pub(super) cost: f32,
    /// What each box of a leaf costs.
    pub(super) cost_each: f32,
    /// Whether a leaf takes `most` places, its last box repeated in those it does not need.
    pub(super) padded: bool,
}

/// A finished tree.
pub(super) struct Built {
    pub(super) nodes: Vec<Node>,
    /// The box at each place.
    pub(super) order: Vec<u32>,
    /// The most children that can wait at once.
    pub(super) waiting: usize,
}

/// What opening a node costs.
const NODE: f32 = 1.0;

/// The cut of a binary tree.
struct Cut<'a> {
    binary: &'a Bvh2,
    leaves: Leaves,
    /// C(n, i) at [n][i - 1].
    costs: Vec<[f32; WIDTH]>,
    /// How many boxes are below each node.
    counts: Vec<u32>,
    /// Whether a node is best made a leaf.
    is_leaf: Vec<bool>,
}

/// Builds the tree of these boxes.
pub(super) fn build(boxes: &[obvhs::aabb::Aabb], leaves: Leaves) -> Built {
    let mut built = Built { nodes: Vec::new(), order: Vec::new(), waiting: 0 };
    if boxes.is_empty() {
        return built;
    }
    let binary = build_binary(boxes);
    Cut::new(&binary, leaves).gather(&mut built);
    built
}

/// Builds the binary tree, one box a leaf.
fn build_binary(boxes: &[obvhs::aabb::Aabb]) -> Bvh2 {
    let preset = BvhBuildParams::medium_build();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        preset.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        preset.sort_precision,
        preset.search_depth_threshold,
    );
    // Reinsertion keeps a stack of fixed size, which only a tree of ordinary depth respects.
    let ordinary = tree.max_depth <= obvhs::bvh2::DEFAULT_MAX_STACK_DEPTH;
    if ordinary {
        ReinsertionOptimizer::default().run(&mut tree, preset.reinsertion_batch_ratio, None);
    }
    tree
}

impl<'a> Cut<'a> {
    fn new(binary: &'a Bvh2, leaves: Leaves) -> Self {
        let nodes = binary.nodes.len();
        let mut cut = Self {
            binary,
            leaves,
            costs: vec![[0.0; WIDTH]; nodes],
            counts: vec![0; nodes],
            is_leaf: vec![false; nodes],
        };
        for at in parents_first(binary).into_iter().rev() {
            cut.weigh(at);
        }
        cut
    }

    /// Finds the costs of a node from those of its children.
    fn weigh(&mut self, at: usize) {
        let node = &self.binary.nodes[at];
        let area = node.aabb().half_area();
        let as_leaf = |count: u32| area * (self.leaves.cost + self.leaves.cost_each * count as f32);
        let Some([left, right]) = self.children(at) else {
            self.counts[at] = node.prim_count;
            self.costs[at] = [as_leaf(node.prim_count); WIDTH];
            self.is_leaf[at] = true;
            return;
        };
        let count = self.counts[left] + self.counts[right];
        let as_node = area * NODE + self.shared(left, right, WIDTH).0;
        let small = count <= self.leaves.most;
        self.is_leaf[at] = small && as_leaf(count) <= as_node;
        let mut costs = [if self.is_leaf[at] { as_leaf(count) } else { as_node }; WIDTH];
        for i in 2..=WIDTH {
            costs[i - 1] = costs[i - 2].min(self.shared(left, right, i).0);
        }
        self.counts[at] = count;
        self.costs[at] = costs;
    }

    /// Returns the two nodes below one, unless it is a leaf of the binary tree.
    fn children(&self, at: usize) -> Option<[usize; 2]> {
        let node = &self.binary.nodes[at];
        let first = node.first_index as usize;
        (node.prim_count == 0).then_some([first, first + 1])
    }

    /// Shares `roots` wide children out between two nodes: the cost, and how many the first gets.
    fn shared(&self, left: usize, right: usize, roots: usize) -> (f32, usize) {
        let cost = |k: usize| self.costs[left][k - 1] + self.costs[right][roots - k - 1];
        let mut best = (cost(1), 1);
        for k in 2..roots {
            let cost = cost(k);
            if cost < best.0 {
                best = (cost, k);
            }
        }
        best
    }

    /// Makes the wide nodes. Iterative: a tree may be as deep as it has boxes.
    fn gather(&self, built: &mut Built) {
        let mut todo = vec![(0_usize, 0_usize, 0_usize)];
        built.nodes.push(Node::EMPTY);
        while let Some((at, slot, above)) = todo.pop() {
            let roots = self.roots_below(at);
            // All children but one wait while that one is opened.
            let waiting = above + roots.len() - 1;
            built.waiting = built.waiting.max(waiting);
            for (lane, root) in roots.into_iter().enumerate() {
                let bounds = self.binary.nodes[root].aabb();
                let child = if self.is_leaf[root] {
                    self.leaf(root, &mut built.order)
                } else {
                    let first = built.nodes.len();
                    built.nodes.push(Node::EMPTY);
                    todo.push((root, first, waiting));
                    Child { first: first as u32, boxes: 0 }
                };
                let bounds: SmallBox = [bounds.min.to_array(), bounds.max.to_array()];
                built.nodes[slot].fill(lane, bounds, child);
            }
        }
    }

    /// Returns the binary nodes that become the children of a wide node; itself, where it is a
    /// leaf.
    fn roots_below(&self, at: usize) -> Vec<usize> {
        let mut roots = Vec::with_capacity(WIDTH);
        let mut todo = Vec::with_capacity(WIDTH);
        match self.children(at) {
            Some([left, right]) if !self.is_leaf[at] => {
                let (_, k) = self.shared(left, right, WIDTH);
                todo.extend([(right, WIDTH - k), (left, k)]);
            }
            _ => roots.push(at),
        }
        while let Some((at, most)) = todo.pop() {
            let worth = most > 1 && self.costs[at][most - 1] < self.costs[at][0];
            match self.children(at) {
                Some([left, right]) if worth => {
                    let most = self.fewest(at, most);
                    let (_, k) = self.shared(left, right, most);
                    todo.extend([(right, most - k), (left, k)]);
                }
                _ => roots.push(at),
            }
        }
        roots
    }

    /// Returns the fewest roots that cost no more than `most`.
    fn fewest(&self, at: usize, most: usize) -> usize {
        let cost = self.costs[at][most - 1];
        (1..most).find(|i| self.costs[at][i - 1] <= cost).unwrap_or(most)
    }

    /// Puts the boxes below a node in their order.
    fn leaf(&self, at: usize, order: &mut Vec<u32>) -> Child {
        let first = order.len();
        let mut todo = vec![at];
        while let Some(at) = todo.pop() {
            if let Some([left, right]) = self.children(at) {
                todo.extend([right, left]);
                continue;
            }
            let node = &self.binary.nodes[at];
            let places = node.first_index..node.first_index + node.prim_count;
            order.extend(places.map(|place| self.binary.primitive_indices[place as usize]));
        }
        let full = if self.leaves.padded { self.leaves.most as usize } else { order.len() - first };
        if let Some(&last) = order.last() {
            order.resize(first + full, last);
        }
        Child { first: first as u32, boxes: full as u32 }
    }
}

/// Lists the nodes, every one after its parent.
fn parents_first(binary: &Bvh2) -> Vec<usize> {
    let mut order = Vec::with_capacity(binary.nodes.len());
    order.push(0);
    let mut next = 0;
    while let Some(&at) = order.get(next) {
        next += 1;
        let node = &binary.nodes[at];
        if node.prim_count == 0 {
            order.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream};
    use obvhs::aabb::Aabb;

    fn boxes(count: usize) -> Vec<Aabb> {
        let mut stream = Stream::new(Randomness::Pseudorandom, 9, 0);
        let mut next = || stream.next_4d().map(|x| x as f32);
        let mut random = || {
            let [x, y, z, size] = next();
            let min = glam::Vec3A::new(x, y, z);
            Aabb::new(min, min + 0.1 * size)
        };
        (0..count).map(|_| random()).collect()
    }

    /// The expected work of a ray in a finished tree.
    fn cost(built: &Built, leaves: Leaves, at: usize) -> f32 {
        let node = &built.nodes[at];
        let of = |lane: usize| {
            let child = node.child(lane);
            let leaf = leaves.cost + leaves.cost_each * child.boxes as f32;
            let area = node.half_area(lane);
            match child.boxes {
                0 => area * NODE + cost(built, leaves, child.first as usize),
                _ => area * leaf,
            }
        };
        (0..WIDTH).filter(|&lane| node.half_area(lane) > 0.0).map(of).sum()
    }

    #[test]
    fn tree_costs_what_its_cut_promised() {
        let all = boxes(3000);
        for leaves in [
            Leaves { most: 4, cost: 0.0, cost_each: 1.0, padded: false },
            Leaves { most: 8, cost: 1.5, cost_each: 0.0, padded: true },
        ] {
            let binary = build_binary(&all);
            let cut = Cut::new(&binary, leaves);
            let built = build(&all, leaves);
            let root = binary.nodes[0].aabb().half_area() * NODE;
            let (promised, found) = (cut.costs[0][0], root + cost(&built, leaves, 0));
            // Thousands of sums in f32, of one sign.
            assert!((promised - found).abs() <= 1e-4 * promised, "{promised} {found}");
        }
    }
}
