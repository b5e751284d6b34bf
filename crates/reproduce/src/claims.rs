//! The claims of the dissertation, judged by computing.

use super::Kind;
use super::evidence::{self, Formulas};
use haptic_analysis::AnalysisError;
use serde::Serialize;

pub use super::evidence::Evidence;

/// Verdict of both operators together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum ClaimVerdict {
    /// With both.
    #[serde(rename = "holds")]
    Holds,
    /// With the dissertation's polynomial alone.
    #[serde(rename = "holds only with A3")]
    OnlyWithMuir,
    /// With the exact operator alone.
    #[serde(rename = "holds only with the exact operator")]
    OnlyExact,
    /// With neither.
    #[serde(rename = "does not hold")]
    No,
}

impl ClaimVerdict {
    pub(crate) fn of(muir: bool, exact: bool) -> Self {
        match (muir, exact) {
            (true, true) => Self::Holds,
            (true, false) => Self::OnlyWithMuir,
            (false, true) => Self::OnlyExact,
            (false, false) => Self::No,
        }
    }

    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::OnlyWithMuir => "holds only with A₃",
            Self::OnlyExact => "holds only with the exact operator",
            Self::No => "does not hold",
        }
    }
}

/// A claim, judged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// C1 to C12, C4 in two.
    pub id: &'static str,
    /// Statement of the dissertation, and how it is read here.
    pub statement: &'static str,
    /// Section of the dissertation.
    pub section: &'static str,
    /// The verdict.
    pub verdict: ClaimVerdict,
    /// With A₃.
    pub muir: Evidence,
    /// With the exact operator.
    pub exact: Evidence,
}

type Judge = fn(Kind, &Formulas) -> Result<Evidence, AnalysisError>;

/// Identifier, statement with its reading, section, and what computes it.
const CLAIMS: [(&str, &str, &str, Judge); 13] = [
    (
        "C1",
        "The stability area in the α–β plane grows with μ on [0, 2]. Read as: it increases at each step of 0.1 in μ, device of 4.4.",
        "4.3",
        evidence::area_grows,
    ),
    (
        "C2",
        "The stiffest stable wall is at μ = 2. Read as: the largest α over μ in steps of 0.1 is at 2.",
        "4.3, 4.5",
        evidence::stiffest_at_two,
    ),
    (
        "C3",
        "The largest β falls from μ = 1.5 to μ = 2.",
        "4.5",
        evidence::largest_beta_falls,
    ),
    (
        "C4a",
        "For larger μ the region changes less with the sample time T. Read as: the relative change of its area in the plane of α = KT²/m and β = BT^(2−μ)/m with the varied T, from half to twice T, falls with μ over 0, 0.5, 1, 1.5, 2, with a hand of 500 N/m and without one.",
        "4.6",
        evidence::robust_to_time,
    ),
    (
        "C4b",
        "For larger μ the region changes less with the damping b. Read as: the relative change of its area in the α–β plane, from half to twice b, falls with μ over 0, 0.5, 1, 1.5, 2, with a hand of 500 N/m and without one.",
        "4.6",
        evidence::robust_to_damping,
    ),
    (
        "C5",
        "The hand's stiffness k has no significant effect on the region. Read as: from k = 0 to 1000 N/m the area changes by less than 5 % for each of the five orders.",
        "4.6",
        evidence::robust_to_hand,
    ),
    (
        "C6",
        "A smaller μ lowers the peak of the sensitivity. Read as: the peak rises with μ over the five orders, at α = β = 0.05.",
        "4.7",
        evidence::sensitivity_rises,
    ),
    (
        "C7",
        "The wall is passive if (5.1) holds, which is Colgate's condition at μ = 1. Read as: the damping of (5.1) is at least the least one by Theorem 1, over μ in steps of 0.1 and three walls, and equal to Colgate's at μ = 1.",
        "5.1",
        evidence::corollary_one,
    ),
    (
        "C8",
        "The passivity region is larger for 0 ≤ μ < 1 than at 1 and least as μ → 2. Read as: its area falls at each step of 0.25.",
        "5.1",
        evidence::passivity_region,
    ),
    (
        "C9",
        "(5.20) makes the coupled port passive for μ ≤ 1, and nothing does for μ > 1. Read as: at least Llewellyn's least damping for 25 couplers, and none exists for μ = 1.25, 1.5, 2.",
        "5.2",
        evidence::corollary_two,
    ),
    (
        "C10",
        "For μ ≤ 1 the B term never lowers the effective stiffness; for μ > 1 it can. Read as: the sign of Re P over all frequencies.",
        "3.5, 6",
        evidence::effective_stiffness,
    ),
    (
        "C11",
        "History decays exponentially, so short memory suffices. Read as: 200 s after a 1 s ramp the force from short memory is within 1 % (last 1000 samples of the exact operator; A₃ as it is).",
        "3.2",
        evidence::short_memory,
    ),
    (
        "C12",
        "The rendered relaxation follows the tissue for 200 s. Read as: within 1 % of the closed form from 1.1 s on (full memory 1e-6 for the exact operator).",
        "7",
        evidence::relaxation,
    ),
];

/// Number of claims.
pub const COUNT: usize = CLAIMS.len();

/// Judges all claims; `done` is called after each and says whether to go on.
///
/// # Errors
/// None: all parameters are constants.
pub fn judge_all(done: &dyn Fn() -> bool) -> Result<Vec<Claim>, AnalysisError> {
    judge_by(&Formulas::DISSERTATION, done)
}

fn judge_by(formulas: &Formulas, done: &dyn Fn() -> bool) -> Result<Vec<Claim>, AnalysisError> {
    let mut claims = Vec::with_capacity(COUNT);
    for (id, statement, section, judge) in CLAIMS {
        let muir = judge(Kind::Muir, formulas)?;
        let exact = judge(Kind::Exact, formulas)?;
        claims.push(Claim {
            id,
            statement,
            section,
            verdict: ClaimVerdict::of(muir.holds, exact.holds),
            muir,
            exact,
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

    fn verdict(claims: &[Claim], id: &str) -> ClaimVerdict {
        let claim = claims.iter().find(|claim| claim.id == id);
        claim.expect("all are judged").verdict
    }

    #[test]
    fn verdicts_follow_from_the_two_operators() {
        assert_eq!(ClaimVerdict::of(true, true), ClaimVerdict::Holds);
        assert_eq!(ClaimVerdict::of(true, false), ClaimVerdict::OnlyWithMuir);
        assert_eq!(ClaimVerdict::of(false, true), ClaimVerdict::OnlyExact);
        assert_eq!(ClaimVerdict::of(false, false), ClaimVerdict::No);
    }

    /// Verdicts on the claims that no finding is about.
    const AS_THE_NUMBERS_HAVE_IT: [(&str, ClaimVerdict); 9] = [
        ("C1", ClaimVerdict::OnlyExact),
        ("C2", ClaimVerdict::Holds),
        ("C3", ClaimVerdict::Holds),
        ("C4a", ClaimVerdict::OnlyWithMuir),
        ("C4b", ClaimVerdict::OnlyWithMuir),
        ("C5", ClaimVerdict::No),
        ("C6", ClaimVerdict::No),
        ("C8", ClaimVerdict::Holds),
        ("C10", ClaimVerdict::Holds),
    ];

    #[test]
    fn the_findings_of_the_theory_come_out_and_a_broken_formula_changes_its_verdict() {
        let broken = Formulas {
            // Forgets the 2^(μ−1): right at μ = 1 only.
            passivity: |_, alpha, beta| Ok(0.5 * alpha + beta),
            // Twice as careful, which is enough.
            coupling: |mu, t, k, b| 3.0 * (k + b * (0.5 * t).powf(mu)) / 8.0,
            // A tissue 5 % stiffer than the one that was rendered.
            stress_factor: 1.05,
        };
        let (truth, claims) = std::thread::scope(|scope| {
            let claims = scope.spawn(|| judge_by(&broken, &|| true).expect("judges"));
            let truth = judge_all(&|| true).expect("judges");
            (truth, claims.join().expect("ends"))
        });
        assert_eq!(truth.len(), COUNT);
        // Finding 3: (5.1) holds for the exact operator alone. Finding 4: (5.20) for neither.
        assert_eq!(verdict(&truth, "C7"), ClaimVerdict::OnlyExact);
        assert_eq!(verdict(&truth, "C9"), ClaimVerdict::No);
        // Finding 1: short memory fails; full memory follows the tissue, A₃ does not.
        assert_eq!(verdict(&truth, "C11"), ClaimVerdict::No);
        assert_eq!(verdict(&truth, "C12"), ClaimVerdict::OnlyExact);
        // The rest, as the numbers have it: a slip in one of their formulas shows here.
        for (id, want) in AS_THE_NUMBERS_HAVE_IT {
            assert_eq!(verdict(&truth, id), want, "{id}");
        }
        let numbers = |id: &str, kind: fn(&Claim) -> &Evidence| {
            let claim = truth.iter().find(|claim| claim.id == id);
            kind(claim.expect("judged")).numbers.clone()
        };
        // Finding 3: A₃ needs 1.33 times the damping of (5.1) at μ = 1 and at 1.5, and a little more between. For the
        // exact operator (5.1) is the least damping.
        let muir = numbers("C7", |claim| &claim.muir);
        let factor = muir
            .split_whitespace()
            .nth(5)
            .and_then(|word| word.parse().ok());
        let factor: f64 = factor.unwrap_or_else(|| panic!("{muir}"));
        assert!((1.33..1.35).contains(&factor), "{muir}");
        let exact = numbers("C7", |claim| &claim.exact);
        assert!(exact.contains("at least 1.000000000 times"), "{exact}");
        // The stiffest wall at 2 is held against another, not against itself.
        let kinds: [fn(&Claim) -> &Evidence; 2] = [|claim| &claim.muir, |claim| &claim.exact];
        for said in kinds.map(|kind| numbers("C2", kind)) {
            let decimals = |word: &&str| {
                word.split_once('.')
                    .is_some_and(|(_, after)| after.len() == 4)
            };
            let alphas: Vec<&str> = said.split([' ', ',', ';']).filter(decimals).collect();
            assert!(alphas.len() == 2 && alphas[0] > alphas[1], "{said}");
        }
        let c9 = truth.iter().find(|claim| claim.id == "C9").expect("judged");
        assert!(
            c9.exact.numbers.contains("2.000 times"),
            "{}",
            c9.exact.numbers
        );

        // Of the broken formulas.
        assert_eq!(verdict(&claims, "C7"), ClaimVerdict::No);
        assert_eq!(verdict(&claims, "C9"), ClaimVerdict::Holds);
        assert_eq!(verdict(&claims, "C12"), ClaimVerdict::No);
        // The others do not use these formulas.
        for id in [
            "C1", "C2", "C3", "C4a", "C4b", "C5", "C6", "C8", "C10", "C11",
        ] {
            assert_eq!(verdict(&claims, id), verdict(&truth, id), "{id}");
        }
    }

    #[test]
    fn corollary_one_says_if_and_not_only_if() {
        let holds = |kind, passivity| {
            let formulas = Formulas {
                passivity,
                ..Formulas::DISSERTATION
            };
            let evidence = evidence::corollary_one(kind, &formulas).expect("judges");
            evidence.holds
        };
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
