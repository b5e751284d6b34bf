//! Coulomb friction over one step, chosen implicitly.
//!
//! ```text
//! v(h) = w + Y·r,  |r| ≤ Fc:    r = -w/Y if that is within Fc, so that v(h) = 0;
//!                               r = -Fc·sign(w) otherwise
//! ```
//! - *Symbols*: r friction force N, Fc its limit N, w the velocity without friction at the end of the
//!   step h, m/s, Y > 0 velocity gained per newton held over the step, m/(N·s).
//! - *Why implicit*: a force that follows sign(v) chatters about zero for ever; this one ends there.
//! - *Accuracy*: the force is held over the step, so the instants of stopping and of reversing are
//!   right to one step (first order in time); while sliding one way it is exact.
//!
//! Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988
//! (time stepping for dry friction), for one scalar contact.

/// The effect of friction in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Friction {
    /// It can bring the velocity to zero at the end of the step, with this force, N.
    Stops(f64),
    /// It can not, and opposes the motion with this force, N.
    Slides(f64),
}

/// Chooses the friction force. `limit` ≥ 0 in N, `mobility` Y > 0 in m/(N·s).
pub(super) fn coulomb(limit: f64, free_velocity: f64, mobility: f64) -> Friction {
    let stopping = -free_velocity / mobility;
    if stopping.abs() <= limit {
        Friction::Stops(stopping)
    } else {
        Friction::Slides(libm::copysign(limit, stopping))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stops_what_it_can_and_opposes_the_rest() {
        // Y = 0.5 m/(N·s): 1 m/s needs 2 N.
        assert_eq!(coulomb(2.0, 1.0, 0.5), Friction::Stops(-2.0));
        assert_eq!(coulomb(1.9, 1.0, 0.5), Friction::Slides(-1.9));
        assert_eq!(coulomb(1.9, -1.0, 0.5), Friction::Slides(1.9));
    }
}
