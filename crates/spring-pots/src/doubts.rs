//! Parts of a record beside the model's, taken out of both.
//! ```text
//! r = P(model − record)     P = 1 − BB⁺ of parts B·c of any size
//! P = 1 − U·(1 − 1/√(1 + S²))·Uᵀ of parts D·d, D = USVᵀ in deviations of the noise, d normal with deviation 1
//! ```
//! ‖P(model − record)‖² is the least over d of ‖model + D·d − record‖² + ‖d‖²: small parts are left in, large ones are projected out, and errors of the
//! parameters account for the fit of c and d (G. H. Golub, V. Pereyra, *Separable nonlinear least squares*, 2003).

use nalgebra::DMatrix;

/// P, by its columns of unit length and what of each is taken out.
#[derive(Clone, Debug, Default)]
pub struct Doubts(Vec<(Vec<f64>, f64)>);

impl Doubts {
    /// The columns of B and of D, of `rows` numbers each.
    #[must_use]
    pub fn new(rows: usize, free: &[Vec<f64>], bounded: &[Vec<f64>]) -> Self {
        let of =
            |columns: &[Vec<f64>]| DMatrix::from_fn(rows, columns.len(), |row, n| columns[n][row]);
        let mut shares = vec![1.0; free.len()];
        let free = (!free.is_empty()).then(|| of(free).qr().q());
        let bounded = (!bounded.is_empty()).then(|| {
            let mut columns = of(bounded);
            for free in free.iter().flat_map(DMatrix::column_iter) {
                let parts = columns.tr_mul(&free);
                columns -= free * parts.transpose();
            }
            // By the triangle of D, which has few rows.
            let (unit, triangle) = columns.qr().unpack();
            let parts = triangle.svd(true, false);
            let sizes = parts.singular_values.iter();
            shares.extend(sizes.map(|size| 1.0 - 1.0 / libm::sqrt(1.0 + size * size)));
            parts
                .u
                .map_or(DMatrix::zeros(rows, 0), |turned| unit * turned)
        });
        let units = free.iter().chain(&bounded).flat_map(DMatrix::column_iter);
        let units = units.map(|column| column.iter().copied().collect());
        Self(units.zip(shares).collect())
    }

    /// True if nothing is taken out.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes the parts out of as many columns as there are numbers in a row; rows count by their errors, all alike without.
    pub fn take_out(&self, values: &mut [f64], errors: &[f64]) {
        for (column, share) in &self.0 {
            let width = values.len() / column.len();
            let mut sums = vec![0.0; width];
            let error = |row: usize| errors.get(row).copied().unwrap_or(1.0);
            for (n, (row, part)) in values.chunks_exact(width).zip(column).enumerate() {
                let part = part / error(n);
                (sums.iter_mut().zip(row)).for_each(|(sum, value)| *sum += part * value);
            }
            for (n, (row, part)) in values.chunks_exact_mut(width).zip(column).enumerate() {
                let part = share * part * error(n);
                (row.iter_mut().zip(&sums)).for_each(|(value, sum)| *value -= part * sum);
            }
        }
    }
}
