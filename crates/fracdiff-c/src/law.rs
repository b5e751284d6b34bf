//! The law of a spring and a fractional damper in C, around an operator.

use crate::error::HeaderError;
use crate::number::{CNumber, literal};

/// A spring and a fractional damper, as of a piece of tissue.
///
/// ```text
/// f = −(K·x + B·y)        y the output of the operator
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// K, finite and at least 0, in newtons for each unit of x.
    pub stiffness: f64,
    /// B, finite and at least 0, in newtons for each unit of y.
    pub dissipation: f64,
}

/// Force of the law, and the same behind a surface, as `haptic-loop` has them.
const FUNCTIONS: &str = "
/* The force on what is joined to it at the displacement x: -(K x + B y). Changes nothing. */
static inline real @_force(const @_t *self, real x)
{
AS_WRITTEN    return -(STIFFNESS * x + DISSIPATION * @_output(self, x));
}

/* How deep a place is behind a surface at 0; not finite places are no number. */
static inline real @_depth(real x)
{
AS_WRITTEN    const real nothing = x - x;
    return ((x < ZERO) ? ZERO : x) + nothing;
}

/* The force behind that surface: it pushes and never pulls. Take @_depth(x) into the history, not x. */
static inline real @_push(const @_t *self, real x)
{
    const real depth = @_depth(x);
    const real force = @_force(self, depth);
    return ((depth <= ZERO) || (force > ZERO)) ? ZERO : force;
}
";

impl Law {
    /// Its functions.
    pub(crate) fn functions<F: CNumber>(&self) -> Result<String, HeaderError> {
        let number = |value: f64| {
            let rounded = F::from_f64(value);
            if value >= 0.0 && rounded.is_finite() {
                Ok(literal(rounded))
            } else {
                Err(HeaderError::Law { value })
            }
        };
        Ok(FUNCTIONS
            .replace("STIFFNESS", &number(self.stiffness)?)
            .replace("DISSIPATION", &number(self.dissipation)?))
    }
}
