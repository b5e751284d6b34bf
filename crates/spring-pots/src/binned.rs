//! The sum of squares of a record of very many samples, by a few rows for each stretch of ln t or ln ω.
//! ```text
//! ln f(x) = Σ_m c_m(x)·ln f(x_m)  cubic between nodes 1/20 apart       Σ_i wᵢ(ln f(xᵢ) − ln fᵢ)² = Σ_bins ‖R·ln f(x_m) − Qᵀ ln fᵢ‖²
//! ```
//! Of the samples between two nodes five rows are left, R of [√w·c, √w·ln fᵢ] = QR, whatever their number. The error of the
//! interpolation is below 1e-6 of ln f where it bends by less than 1 over a factor e. What is reported comes from all samples.
//!
//! *Cost*: a model at some 20 nodes for each factor e, and 4 products a row.

use crate::contour::Quantity;
use crate::cubic;
use crate::elements::Slope;
use nalgebra::DMatrix;

/// Distance of the nodes in ln t or ln ω.
const SPACING: f64 = 0.05;

/// A long record as rows between nodes.
#[derive(Clone, Debug)]
pub struct Binned {
    /// The quantity; `None` for storage and loss modulus.
    pub quantity: Option<Quantity>,
    first_node: f64,
    nodes: usize,
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    /// 1 for the loss modulus.
    part: usize,
    node: usize,
    weights: [f64; 4],
}

impl Binned {
    /// The rows, and what they are to reach, of values in parts of the length of x, which rises; none if they were hardly fewer.
    pub fn new(
        quantity: Option<Quantity>,
        ln_x: &[f64],
        wanted: &[f64],
        roots: &[f64],
    ) -> Option<(Self, Vec<f64>)> {
        let samples = ln_x.len();
        // Between two nodes, whatever the rounding.
        let first_node = ln_x[0] - 1.5 * SPACING;
        let in_nodes = |i: usize| (ln_x[i] - first_node) / SPACING;
        let nodes = in_nodes(samples - 1) as usize + 3;
        if samples < 10 * nodes {
            return None;
        }
        let (mut rows, mut reached) = (Vec::new(), Vec::new());
        for part in 0..wanted.len() / samples {
            let all: Vec<usize> = (0..samples).collect();
            for bin in all.chunk_by(|&i, &j| in_nodes(i) as usize == in_nodes(j) as usize) {
                let node = in_nodes(bin[0]) as usize;
                let whole = DMatrix::from_fn(bin.len(), 5, |row, column| {
                    let n = part * samples + bin[row];
                    let weights = cubic(in_nodes(bin[row]) - node as f64);
                    roots[n] * weights.get(column).copied().unwrap_or(wanted[n])
                });
                for row in whole.qr().r().row_iter() {
                    let weights = core::array::from_fn(|column| row[column]);
                    rows.push(Row {
                        part,
                        node,
                        weights,
                    });
                    reached.push(row[4]);
                }
            }
        }
        let binned = Self {
            quantity,
            first_node,
            nodes,
            rows,
        };
        Some((binned, reached))
    }

    /// Calls `each` with number and value of each row, of the logarithms at ln x.
    pub fn model(&self, at: &mut dyn FnMut(f64) -> [Slope; 2], mut each: impl FnMut(usize, Slope)) {
        let nodes: Vec<[Slope; 2]> = (0..self.nodes)
            .map(|m| at(self.first_node + m as f64 * SPACING))
            .collect();
        for (n, row) in self.rows.iter().enumerate() {
            let around = nodes[row.node - 1..].iter().map(|node| &node[row.part]);
            each(n, Slope::sum(&row.weights, around));
        }
    }
}
