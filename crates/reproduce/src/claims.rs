//! The claims of the dissertation, judged by computing.

use super::Kind;
use super::evidence::{self, Found};
use haptic_analysis::AnalysisError;
use serde::{Serialize, Serializer};

pub use super::evidence::Evidence;

/// A claim of the dissertation with the verdict on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// C1 to C17, C4 in two.
    pub id: &'static str,
    /// Statement of the dissertation, and how it is read here.
    pub statement: &'static str,
    /// Section of the dissertation that makes the claim, as in 4.4.
    pub section: &'static str,
    /// The verdict in words, over all operators that it was tried with.
    pub verdict: String,
    /// The evidence with the chapter's operator and, if that differs, with (1 − w)^μ. In JSON each
    /// is under its name; the others are null.
    #[serde(flatten, serialize_with = "by_operator")]
    pub evidence: Vec<Evidence>,
}

fn by_operator<S: Serializer>(evidence: &[Evidence], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(KEYS.map(|(key, kind)| {
        let found = evidence.iter().find(|one| one.operator == kind.name());
        (key, found)
    }))
}

const KEYS: [(&str, Kind); 4] = [
    ("muir", Kind::Muir),
    ("exact", Kind::Exact),
    ("continuous", Kind::Continuous),
    ("oustaloup", Kind::Oustaloup),
];

/// The verdict of the chapter's operator, and of the one beside it.
fn verdict(evidence: &[Evidence]) -> String {
    if evidence.iter().any(|one| one.holds.is_none()) {
        return "not judged".to_owned();
    }
    let only = evidence.iter().filter(|one| one.holds == Some(true));
    match only.clone().count() {
        0 => "does not hold".to_owned(),
        count if count == evidence.len() => "holds".to_owned(),
        _ => format!(
            "holds only with {}",
            only.map(|one| one.operator).collect::<String>()
        ),
    }
}

type Judge = fn(Kind) -> Found;

/// Operators of the chapters: first the one the author uses, then what is computed beside it.
const EXACT: &[Kind] = &[Kind::Exact];
const MUIR: &[Kind] = &[Kind::Muir];
const UNSAMPLED: &[Kind] = &[Kind::Continuous, Kind::Exact];
const CHAPTER_4: &[Kind] = &[Kind::Muir, Kind::Exact];
const CHAPTER_7: &[Kind] = &[Kind::Oustaloup, Kind::Exact];

/// Identifier, section, operators and what computes it; then the statement with its reading.
macro_rules! claims {
    ($($id:literal, $section:literal, $operators:ident, $judge:ident: $statement:literal;)*) => {
        [$(($id, $section, $statement, $operators, evidence::$judge)),*]
    };
}

const CLAIMS: [(&str, &str, &str, &[Kind], Judge); 19] = claims! {
    "C1", "4.3", CHAPTER_4, area_grows:
        "The stability area in the α–β plane grows with μ on [0, 2]. Read as: it increases over the five orders 0, 0.5, 1, 1.5, 2, device of 4.4.";
    "C2", "4.3, 4.5", CHAPTER_4, stiffest_at_two:
        "The stiffest stable wall is at μ = 2. Read as: the largest α over μ in steps of 0.1 is at 2.";
    "C3", "4.5", CHAPTER_4, largest_beta_falls:
        "The largest β falls from μ = 1.5 to μ = 2.";
    "C4a", "4.6", CHAPTER_4, shrinks_over_time:
        "A longer sample time T reduces the region. Read as: over half, once and twice T the area falls at each of the orders 0, 0.5, 1, 1.5, 2, with a hand of 500 N/m and without one, in the plane of α = KT²/m and β = BT^(2−μ)/m with the varied T or in that of K and B.";
    "C4b", "4.6", CHAPTER_4, robust_to_damping:
        "More damping b enlarges the region, and less so for larger μ. Read as: over half, once and twice b the area in the α–β plane grows at each of the five orders, and its relative change falls with μ, with a hand of 500 N/m and without one.";
    "C4c", "4.6", CHAPTER_4, robust_to_time:
        "A longer sample time T reduces the region less for larger μ. Read as: in a plane of C4a in which the area falls, its relative change falls with μ.";
    "C5", "4.6", CHAPTER_4, robust_to_hand:
        "The hand's stiffness k has no significant effect on the region. Read as: from k = 0 to 1000 N/m the area changes by less than 5 % for each of the five orders.";
    "C6", "4.7", CHAPTER_4, sensitivity_rises:
        "A smaller μ lowers the peak of the sensitivity. Its four numbers are not printed, and the verdict depends on them. Read as: the peak rises with μ over the five orders for every wall tried that is stable at all five; α from 0.01 to 0.2, β from 0.0001 to 0.1, δ half, once and twice that of 4.4, with a hand of 500 N/m and without one, and one wall with α = 0.6146.";
    "C7", "5.1", EXACT, corollary_one:
        "The wall is passive if (5.1) holds, which is Colgate's condition at μ = 1. Read as: the damping of (5.1) is at least the least one by Theorem 1, over μ in steps of 0.1 and three walls, and equal to Colgate's at μ = 1.";
    "C8", "5.1", EXACT, passivity_region:
        "The passivity region is larger for 0 ≤ μ < 1 than at 1 and least as μ → 2. Read as: its area falls at each step of 0.25.";
    "C9", "5.2", EXACT, corollary_two:
        "(5.20) makes the coupled port passive for μ ≤ 1, and nothing does for μ > 1. Read as: at least Llewellyn's least damping for 25 couplers, and none exists for μ = 1.25, 1.5, 2.";
    "C10", "3.5, 6", UNSAMPLED, effective_stiffness:
        "For μ ≤ 1 the B term never lowers the effective stiffness; for μ > 1 it can. Read as: the sign of its share over all frequencies, s^μ behind the hold (6) and (1 − w)^μ alone (3.5).";
    "C11", "3.2", EXACT, short_memory:
        "History decays exponentially, so short memory suffices. Read as: 200 s after a 1 s ramp the force from the last 1000 samples is within 1 %.";
    "C12", "7", CHAPTER_7, relaxation:
        "The rendered relaxation follows the tissue for 200 s. Read as: within 1 % of the closed form from 1.1 s on, with an operator of the kind of [54] (9 sections, 10 µHz to 100 Hz) and with full memory 1e-6.";
    "C13", "3.3, 4.1", CHAPTER_4, classical:
        "At μ = 1 the environment is the classical spring and damper. Read as: the operator of order 1 is 1 − w.";
    "C14", "6", UNSAMPLED, damps:
        "For 1 ≤ μ ≤ 2 the B term always raises the effective damping. Read as: its share behind the hold is positive below the Nyquist frequency, μ in steps of 0.1.";
    "C15", "4.5", MUIR, experiments:
        "The experiments, too, show the largest β fall from μ = 1.5 to 2, and theory and experiment differ the more, the larger μ. His measurements are not at hand, and delay and lag of his device are not printed. Read as: on simulated devices with 0.05 N of friction, an encoder of 1 µm and several delays and lags, the largest β falls and the share of theory's area that is lost rises over the five orders.";
    "C16", "3.5", EXACT, positive_damping:
        "The effective damping (3.13) is positive for 0 < μ < 2. Read as: below the Nyquist frequency, μ in steps of 0.1.";
    "C17", "1", UNSAMPLED, stores:
        "The B term only stores energy at μ = 0 and 2, and dissipates at every order between. Read as: its damping is zero at all frequencies for those two orders alone.";
};

/// Number of claims, for a progress bar.
pub const COUNT: usize = CLAIMS.len();

/// Judges all claims; `done` is called after each and returns true to continue.
///
/// # Errors
/// None: all parameters are constants.
pub fn judge_all(done: &dyn Fn() -> bool) -> Result<Vec<Claim>, AnalysisError> {
    let mut claims = Vec::with_capacity(COUNT);
    for (id, section, statement, kinds, judge) in CLAIMS {
        let mut evidence = Vec::new();
        for kind in kinds {
            let (holds, numbers) = judge(*kind)?;
            let operator = kind.name();
            evidence.push(Evidence {
                operator,
                holds,
                numbers,
            });
        }
        let verdict = verdict(&evidence);
        claims.push(Claim {
            id,
            section,
            statement,
            verdict,
            evidence,
        });
        if !done() {
            break;
        }
    }
    Ok(claims)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::Order;
    use haptic_analysis::corollary_delta;

    #[test]
    fn verdicts_follow_from_the_operator_of_the_chapter_and_the_one_beside_it() {
        let evidence = |operator, holds| Evidence {
            operator,
            holds: Some(holds),
            numbers: String::new(),
        };
        for (ours, reference, want) in [
            (true, true, "holds"),
            (true, false, "holds only with A₃"),
            (false, true, "holds only with (1 − w)^μ"),
            (false, false, "does not hold"),
        ] {
            let both = [evidence("A₃", ours), evidence("(1 − w)^μ", reference)];
            assert_eq!(verdict(&both), want);
        }
        assert_eq!(verdict(&[evidence("(1 − w)^μ", true)]), "holds");
        assert_eq!(verdict(&[evidence("(1 − w)^μ", false)]), "does not hold");
        let open = Evidence {
            holds: None,
            ..evidence("A₃", true)
        };
        assert_eq!(verdict(&[evidence("A₃", true), open]), "not judged");
    }

    /// Verdicts as the numbers have them, with the operators of the chapter.
    const WANTED: [(&str, &str, &[&str]); 19] = [
        ("C1", "holds", &["A₃", "(1 − w)^μ"]),
        ("C2", "holds", &["A₃", "(1 − w)^μ"]),
        ("C3", "holds", &["A₃", "(1 − w)^μ"]),
        ("C4a", "holds", &["A₃", "(1 − w)^μ"]),
        ("C4b", "holds only with A₃", &["A₃", "(1 − w)^μ"]),
        ("C4c", "does not hold", &["A₃", "(1 − w)^μ"]),
        ("C5", "does not hold", &["A₃", "(1 − w)^μ"]),
        ("C6", "not judged", &["A₃", "(1 − w)^μ"]),
        ("C7", "holds", &["(1 − w)^μ"]),
        ("C8", "holds", &["(1 − w)^μ"]),
        ("C9", "does not hold", &["(1 − w)^μ"]),
        ("C10", "holds", &["s^μ", "(1 − w)^μ"]),
        ("C11", "does not hold", &["(1 − w)^μ"]),
        ("C12", "holds", &["Oustaloup's operator", "(1 − w)^μ"]),
        ("C13", "holds only with (1 − w)^μ", &["A₃", "(1 − w)^μ"]),
        ("C14", "holds only with s^μ", &["s^μ", "(1 − w)^μ"]),
        ("C15", "not judged", &["A₃"]),
        ("C16", "holds", &["(1 − w)^μ"]),
        ("C17", "holds only with s^μ", &["s^μ", "(1 − w)^μ"]),
    ];

    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn each_claim_is_judged_with_the_operator_of_its_chapter() {
        let claims = judge_all(&|| true).expect("judges");
        let operators = |claim: &Claim| -> Vec<&str> {
            claim.evidence.iter().map(|one| one.operator).collect()
        };
        assert_eq!(claims.len(), COUNT);
        for (claim, (id, verdict, with)) in claims.iter().zip(WANTED) {
            let found = (claim.id, claim.verdict.as_str());
            assert_eq!(found, (id, verdict), "{claim:?}");
            assert_eq!(operators(claim), with, "{id}");
            assert!(!claim.statement.contains("A₃"), "{}", claim.statement);
        }
        // Numbers of another program, and closed forms.
        let says = |id: &str, which: usize, words: &[&str]| {
            let claim = claims.iter().find(|claim| claim.id == id).expect("judged");
            let numbers = &claim.evidence[which].numbers;
            for word in words {
                assert!(numbers.contains(word), "{id}: {word:?} is not in {numbers}");
            }
        };
        // In α–β the region grows with T, in K–B it shrinks; the change falls throughout in one and from 0.5 on in the other.
        says(
            "C4a",
            0,
            &["it grows (0.9131, 1.2755, 2.0251 at μ = 1)", "it shrinks"],
        );
        says(
            "C4a",
            0,
            &["3.6492, 7.5783, 5.5287, 4.5292, 3.1020 (falls from μ = 0.5 on)"],
        );
        says(
            "C7",
            0,
            &[
                "at least 1.000000000 times",
                "is Colgate's",
                "needs up to 1.341 times",
            ],
        );
        // The least damping of Llewellyn at k_c = 0, μ = 1 is b_c T/8, twice that of (5.20).
        says(
            "C9",
            0,
            &[
                "9 of 25",
                "1.018 times",
                "2.000 times at worst (μ = 1, k_c : b_c(T/2)^μ = 0 : 1)",
            ],
        );
        // He draws five orders; the polynomial's fall lies between two of them.
        says(
            "C1",
            0,
            &[
                "0.0241, 0.2487, 1.3066, 2.0792, 2.1407",
                "falls by 0.5 % from μ = 1.8",
            ],
        );
        let rising = "1.4374, 1.6895, 2.5372, 3.6591, 5.1639";
        says("C6", 0, &[rising]);
        // Theory's region does not hold the wedge beneath α = −A₃(1)·β, nor may the simulated one.
        says("C15", 0, &["yes with a delay of 0 ms", "0.9560, 0.9429"]);
        says("C11", 0, &["3.287 times the truth"]);
        // A₃(w, 1) = (1 − w)(1 + w²/3).
        says("C13", 0, &["1.3333 at low frequency, 0.6667 at θ = π/2"]);
        // The phase μ(π − θ)/2 − θ/2 is negative from θ = πμ/(1 + μ) on.
        says(
            "C14",
            1,
            &[
                "θ = 1.572 at μ = 1,",
                "θ = 1.885 at μ = 1.5,",
                "θ = 2.095 at μ = 2",
            ],
        );
    }

    #[test]
    fn a_broken_formula_changes_its_verdict() {
        let holds = |found: Found| found.expect("judges").0 == Some(true);
        // Forgets the 2^(μ−1): right at μ = 1 only.
        let passivity = |_, alpha, beta| Ok(0.5 * alpha + beta);
        assert!(!holds(evidence::is_enough(Kind::Exact, passivity)));
        // Three times as careful, which is enough.
        let coupling = |mu, t: f64, k, b: f64| 3.0 * (k + b * (0.5 * t).powf(mu)) / 8.0;
        assert!(holds(evidence::meets_llewellyn(coupling)));
        // A tissue 5 % stiffer than the one that was rendered.
        assert!(!holds(evidence::follows(Kind::Oustaloup, 1.05)));
    }

    #[test]
    fn the_polynomial_of_chapter_4_does_not_render_the_tissue() {
        // 200 s after the start it ends at 13.2 of the closed form.
        let found = evidence::relaxation(Kind::Muir).expect("judges");
        assert!(
            found.0 == Some(false) && found.1.contains("200 s: 1.22e1"),
            "{}",
            found.1
        );
    }

    #[test]
    fn corollary_one_says_if_and_not_only_if() {
        let holds =
            |kind, passivity| evidence::is_enough(kind, passivity).expect("judges").0 == Some(true);
        fn is_one(order: Order) -> bool {
            (order.get() - 1.0).abs() < 1e-9
        }
        let exact = |passivity| holds(Kind::Exact, passivity);
        assert!(exact(corollary_delta));
        // Enough, and more than enough but at μ = 1: the claim still holds.
        let careful = |order: Order, alpha: f64, beta: f64| {
            let factor = if is_one(order) { 1.0 } else { 1.5 };
            corollary_delta(order, alpha, beta).map(|delta| factor * delta)
        };
        assert!(exact(careful));
        // Not Colgate's at μ = 1; too little at another order.
        assert!(!exact(|order, alpha, beta| corollary_delta(
            order, alpha, beta
        )
        .map(|d| 1.5 * d)));
        assert!(!exact(|order, alpha, beta| {
            let factor = if is_one(order) { 1.0 } else { 0.99 };
            corollary_delta(order, alpha, beta).map(|delta| factor * delta)
        }));
        assert!(!holds(Kind::Muir, corollary_delta));
    }
}
