//! The modes of any model.

use super::exponentials::{Response, Spectrum};
use super::form::Form;
use super::prony;

/// G or J for times from `shortest` to `longest`, 0 < `shortest` ≤ `longest`.
pub(super) fn spectrum(form: &Form, response: Response, shortest: f64, longest: f64) -> Spectrum {
    match form {
        Form::Prony {
            elastic_modulus_pa,
            branches,
        } => match response {
            Response::Relaxation => prony::relaxation(*elastic_modulus_pa, branches),
            Response::Creep => prony::creep(*elastic_modulus_pa, branches),
        },
        _ => Spectrum::over_the_cut(form, response, shortest, longest),
    }
}
