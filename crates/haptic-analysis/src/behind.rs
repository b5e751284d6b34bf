//! A simulated object as the characteristic function sees it.

/// The object without units, e/u with e and u in powers of v = 1 − w, divided by the largest that e can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Behind {
    pub(crate) e: [f64; 3],
    pub(crate) u: [f64; 2],
}

impl Behind {
    /// From the shares of mass, damping and stiffness: `m_o/m`, `b_o·T/m`, `k_o·T²/m`.
    pub(crate) fn new([mass, damping, stiffness]: [f64; 3]) -> Self {
        let most = 8.0 * mass + 2.0 * damping + 2.0 * stiffness;
        // With mass 2ρv² + δv(2 − v) + γ(2 − v)²/2 over 2 − v; without one both have the factor 2 − v.
        let (e, u) = if mass > 0.0 {
            let e = [
                2.0 * stiffness,
                2.0 * damping - 2.0 * stiffness,
                2.0 * mass - damping + 0.5 * stiffness,
            ];
            (e, [2.0, -1.0])
        } else {
            ([stiffness, damping - 0.5 * stiffness, 0.0], [1.0, 0.0])
        };
        Self {
            e: e.map(|c| c / most),
            u: u.map(|c| c / most),
        }
    }
}
