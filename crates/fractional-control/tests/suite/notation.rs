//! The notation: read, printed, refused.

use fractional_control::{ControlError, FractionalTransferFunction, Term, num_complex::Complex};
use proptest::prelude::*;
use testkit::assert_refused;

fn read(text: &str) -> Result<FractionalTransferFunction, ControlError> {
    text.parse()
}

#[test]
fn the_usual_notation_is_read_and_printed_back() {
    for [text, printed] in testkit::table(
        "
        1/(0.8s^2.2+0.5s^0.9+1) | 1/(0.8s^2.2+0.5s^0.9+1)
         1 / ( 0.8 * s ^ 2.2 + 0.5 s^{0.9} + 1 )  | 1/(0.8s^2.2+0.5s^0.9+1)
        (s+2)/(s^(1/2)*(s+1)+3) | (s+2)/(s^1.5+s^0.5+3)
        (s^0.5+1)^2/(s^2-1e-3) | (s+2s^0.5+1)/(s^2-0.001)
        2/s^0.5 | 2/(s^0.5)
        2s^-0.5 | 2/(s^0.5)
        -3/(s+1) | -3/(s+1)
        4 | 4
        1+1/s^0.5 | (s^0.5+1)/(s^0.5)
        1/(s+1)/(s+2) | 1/(s^2+3s+2)
        1/((s-1)(s+1)) | 1/(s^2-1)
        1/((s^2+s+1)(s^2-s+1)) | 1/(s^4+s^2+1)
        ",
    ) {
        let function = read(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(function.to_string(), printed, "{text}");
        assert_eq!(read(&printed).as_ref(), Ok(&function), "{printed}");
    }
}

#[test]
fn a_refusal_is_one_line_with_the_value_and_the_remedy() {
    for [text, part] in testkit::table(
        "
        s/(s^0.5+1) | the numerator's order 1 exceeds the denominator's order 0.5
        1/(s^2.2-s^2.2+1) | the coefficient of s^2.2 is 0
        1/(0s^2+s+1) | the coefficient of s^2 is 0
        1/(0.0*s^2+s+1) | the coefficient of s^2 is 0
        s^0.5/(s^1.5+s^0.5) | share the factor s^0.5
        1/0 | is 0
        0/(s+1) | is 0
        1/(s^5+1) | order of a term 5 is not in [0, 4]
        exp(-0.5s)/(s+1) | dead time 0.5 s is not 0: only a plant has one
        exp(0.5s)/(s+1) | dead time -0.5 s is not at least 0
        1/(s+1 | character 6
        1/(s+1)) | character 7
        x+1 | character 0
        (s^2+1)^0.5/(s^3+2) | the power of this bracket
        (s+1)^0.5/(s+2) | a bracket to the power 0.5 stands only in a plant
        1/(s+1e400) | a number
        1/(1e300s^2+1)/(1e300s+1) | from 1e-60 to 1e60 in size
        1e308/(s+1) | coefficient 1e308 is not from 1e-60 to 1e60 in size: give plant and controller in other units
        1/(1e-61s+1) | coefficient 1e-61 is not from
        1+exp(-s)/(s+1) | a dead time must precede the whole
        (s+1)^4*(s^0.3+1)^4*(s^0.7+2)^4/(s+1)^4 | more than the largest number, 16
        1/(s+1)/(1/s-1/s) | is 0
        ",
    ) {
        refused(&text, &part);
    }
    refused("", "character 0");
    refused(&"(".repeat(1000), "at most 16 nested brackets");
}

fn refused(text: &str, part: &str) {
    assert_refused(read(text), part);
}

#[test]
fn terms_are_sorted_and_checked() {
    let t = Term::new;
    let function = FractionalTransferFunction::new(&[t(2.0, 0.0)], &[t(1.0, 0.0), t(3.0, 1.5)]);
    assert_eq!(
        function.map(|f| f.to_string()).as_deref(),
        Ok("2/(3s^1.5+1)")
    );
    assert!(matches!(
        FractionalTransferFunction::new(&[], &[t(1.0, 1.0)]),
        Err(ControlError::Empty { what: "numerator" })
    ));
    assert!(FractionalTransferFunction::new(&[t(f64::NAN, 0.0)], &[t(1.0, 1.0)]).is_err());
    assert!(FractionalTransferFunction::new(&[t(1.0, f64::NAN)], &[t(1.0, 1.0)]).is_err());
}

proptest! {
    #[test]
    fn whatever_is_typed_is_read_or_refused(
        letters in prop::collection::vec(prop::sample::select(b"s0123456789().^*/+e{}x -"), 0..40)
    ) {
        let text: String = letters.into_iter().map(char::from).collect();
        if let Ok(function) = read(&text) {
            let again = read(&function.to_string()).expect("what is printed is read");
            let s = Complex::new(0.3, 1.7);
            let (have, want) = (again.at(s), function.at(s));
            prop_assert!((have - want).norm() <= 1e-9 * want.norm() || !want.norm().is_finite());
        }
    }
}
