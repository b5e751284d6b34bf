//! Loading of tissue: the shape of a specimen, and a map from depth to the strain that its memory sees.
//!
//! ```text
//! f = γ·(M ∗ de(δ)/dt)        γ m, M the relaxation modulus Pa, e m, δ depth m
//! ```
//! | loading | γ for the shear modulus | e |
//! |---|---|---|
//! | shear of a slab, area A, thickness h | A/h | δ |
//! | tension, compression of a slab | 2(1+ν)·A/h | δ |
//! | the same between bonded plates, ν = 0.5 | times 1 + 2S², S = √(A/π)/(2h) | δ |
//! | flat punch of radius a | 4a/(1−ν) | δ |
//! | sphere of radius R | 8R/(3(1−ν)) | δ·√(δ/R) |
//! | sphere on a bonded layer, thickness h, ν = 0.5 | the same | times 1 + 1.133χ + 1.283χ² + 0.769χ³ + 0.0975χ⁴, χ = √(Rδ)/h |
//! | sphere on a layer that slides on its base, ν = 0.5 | the same | times 1 + 0.884χ + 0.781χ² + 0.386χ³ + 0.0048χ⁴ |
//! | cone, half angle φ | 4·tan φ·(1 mm)/(π(1−ν)) | δ²/(1 mm) |
//!
//! For Young's modulus γ is divided by 2(1+ν): E(t) = 2(1+ν)·G(t). Tissue that stiffens by b multiplies e by
//! (exp(bε) − 1)/(bε), ε the [nominal strain](Specimen::strain).
//!
//! The memory form holds while the contact grows (E. H. Lee, J. R. M. Radok, *The contact problem for viscoelastic bodies*,
//! J. Appl. Mech. 27, 1960); while it shrinks it is the rendering, no theory.
//!
//! Sources: I. N. Sneddon, Int. J. Eng. Sci. 3, 1965 (punch, cone); A. N. Gent, P. B. Lindley, Proc. Inst. Mech. Eng. 173,
//! 1959 (bonded slab); E. K. Dimitriadis and others, Biophys. J. 82, 2002 (layer); Y. C. Fung, *Biomechanics*, 1981
//! (stiffening).

use crate::error::{Checks, LoopParameterError};
use crate::units::{Metres, SquareMetres};
use core::f64::consts::PI;
use fracdiff::parameter::{positive, range};
use fracdiff::{Real, enumerated};

enumerated! {
    /// Modulus that a number in Pa states.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Modulus {
        /// G, of shear stress over shear strain.
        Shear "shear",
        /// E = 2(1+ν)·G.
        Young "young",
    }
}

enumerated! {
    /// The kinds of [`Loading`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum LoadingKind {
        /// Simple shear of a slab.
        Shear "shear",
        /// Tension of a slab between two plates.
        Tension "tension",
        /// Compression of a slab between two plates.
        Compression "compression",
        /// Indentation by a flat round punch.
        Punch "punch",
        /// Indentation by a sphere, of a deep body or a layer.
        Sphere "sphere",
        /// Indentation of a deep body by a cone.
        Cone "cone",
    }
}

impl LoadingKind {
    /// The modulus in which such a measurement is reported, unless stated otherwise: G for shear,
    /// else E.
    #[must_use]
    pub const fn modulus(self) -> Modulus {
        match self {
            Self::Shear => Modulus::Shear,
            Self::Tension | Self::Compression | Self::Punch | Self::Sphere | Self::Cone => {
                Modulus::Young
            }
        }
    }

    /// The sizes that it needs or may have, by the names that errors use.
    #[must_use]
    pub const fn sizes(self) -> &'static [&'static str] {
        match self {
            Self::Shear => &["area", "thickness"],
            Self::Tension | Self::Compression => &["area", "thickness", "bonded"],
            Self::Punch => &["indenter radius"],
            Self::Sphere => &["indenter radius", "thickness", "bonded"],
            Self::Cone => &["half angle"],
        }
    }

    /// True for a slab, which has an area and a thickness; false for an indenter on a deep body.
    #[must_use]
    pub const fn is_slab(self) -> bool {
        match self {
            Self::Shear | Self::Tension | Self::Compression => true,
            Self::Punch | Self::Sphere | Self::Cone => false,
        }
    }
}

/// Kind of loading of a specimen, with the sizes that this kind has.
///
/// | kind | needs | may have |
/// |---|---|---|
/// | shear, tension, compression | area, thickness | bonded, but for shear |
/// | punch | radius | – |
/// | sphere | radius | thickness: a layer on a base, bonded or not |
/// | cone | half angle | – |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Kind of the loading, which decides what sizes it has.
    pub kind: LoadingKind,
    /// Area A of a slab, m².
    pub area_m2: Option<f64>,
    /// Thickness h of a slab or layer, m.
    pub thickness_m: Option<f64>,
    /// Radius a of a punch or R of a sphere, m.
    pub radius_m: Option<f64>,
    /// Angle of a cone between axis and flank, rad.
    pub half_angle_rad: Option<f64>,
    /// True if a slab cannot slide on its plates, or a layer on its base.
    pub bonded: bool,
}

impl Loading {
    /// A loading of this kind, without sizes yet.
    #[must_use]
    pub const fn new(kind: LoadingKind) -> Self {
        Self {
            kind,
            area_m2: None,
            thickness_m: None,
            radius_m: None,
            half_angle_rad: None,
            bonded: false,
        }
    }

    /// The sizes as a shape, if they are those of the kind.
    fn body(&self) -> Result<Body, LoopParameterError> {
        let kind = self.kind;
        let loading = kind.name();
        let need =
            |size: Option<f64>, what| size.ok_or(LoopParameterError::Missing { what, loading });
        let body = match kind {
            LoadingKind::Shear | LoadingKind::Tension | LoadingKind::Compression => Body::Slab {
                area: need(self.area_m2, "area")?,
                thickness: need(self.thickness_m, "thickness")?,
            },
            LoadingKind::Punch => Body::Punch(need(self.radius_m, "indenter radius")?),
            LoadingKind::Sphere => Body::Sphere {
                radius: need(self.radius_m, "indenter radius")?,
                layer: if self.bonded {
                    Some(need(self.thickness_m, "thickness")?)
                } else {
                    self.thickness_m
                },
            },
            LoadingKind::Cone => Body::Cone(need(self.half_angle_rad, "half angle")?),
        };
        let given = [
            (self.area_m2.is_some(), "area"),
            (self.thickness_m.is_some(), "thickness"),
            (self.radius_m.is_some(), "indenter radius"),
            (self.half_angle_rad.is_some(), "half angle"),
            (self.bonded, "bonded"),
        ];
        let idle = |&(given, what): &(bool, &str)| given && !kind.sizes().contains(&what);
        match given.into_iter().find(idle) {
            Some((_, what)) if !kind.is_slab() && matches!(what, "thickness" | "bonded") => {
                Err(LoopParameterError::Layer { what, loading })
            }
            Some((_, what)) => Err(LoopParameterError::NoEffect { what, loading }),
            None => Ok(body),
        }
    }
}

/// Sizes in m and m², rad.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Slab { area: f64, thickness: f64 },
    Punch(f64),
    Sphere { radius: f64, layer: Option<f64> },
    Cone(f64),
}

/// The length by which the depth of a cone is measured, m.
const CONE_LENGTH: f64 = 1e-3;
/// Powers of χ of a bonded layer, and of one that slides on its base, from χ⁰.
const BONDED_LAYER: [f64; 5] = [1.0, 1.133, 1.283, 0.769, 0.0975];
const FREE_LAYER: [f64; 5] = [1.0, 0.884, 0.781, 0.386, 0.0048];
/// ν of incompressible matter, the usual assumption for soft tissue.
pub const INCOMPRESSIBLE: f64 = 0.5;

/// A piece of tissue: how it is loaded, its Poisson ratio, and its stiffening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    loading: Loading,
    body: Body,
    poisson_ratio: f64,
    stiffening: f64,
}

impl Specimen {
    /// Largest b: at a strain of 0.2 such tissue is five million times as stiff.
    pub const STIFFENING_MAX: f64 = 100.0;
    /// The nominal strain beyond which small-strain theory fails, if nothing better is known.
    pub const SMALL_STRAIN: f64 = 0.2;

    /// Sizes above 0, 0 < half angle < π/2, 0 ≤ ν ≤ 0.5, 0 ≤ b ≤ [`STIFFENING_MAX`](Self::STIFFENING_MAX).
    ///
    /// # Errors
    /// A size that is missing, or that the kind does not have; numbers outside these
    /// ranges; a bonded slab or any layer with ν other than 0.5, for which no formula is implemented; a
    /// cone with b above 0.
    pub fn new(
        loading: Loading,
        poisson_ratio: f64,
        stiffening: f64,
    ) -> Result<Self, LoopParameterError> {
        let body = loading.body()?;
        let nu = poisson_ratio;
        let fits = (0.0..=INCOMPRESSIBLE).contains(&nu);
        range("Poisson's ratio", nu, fits, "in [0, 0.5]", "")?;
        if loading.bonded {
            let what = "Poisson's ratio of a bonded specimen";
            range(what, nu, nu == INCOMPRESSIBLE, "0.5", "")?;
        }
        let fits = (0.0..=Self::STIFFENING_MAX).contains(&stiffening);
        range("stiffening", stiffening, fits, "in [0, 100]", "")?;
        match body {
            Body::Slab { area, thickness } => {
                positive("area", area, "m²")?;
                positive("thickness", thickness, "m")?;
            }
            Body::Punch(radius) => {
                positive("indenter radius", radius, "m")?;
            }
            Body::Sphere { radius, layer } => {
                positive("indenter radius", radius, "m")?;
                positive("thickness", layer.unwrap_or(radius), "m")?;
                let fits = layer.is_none() || nu == INCOMPRESSIBLE;
                range("Poisson's ratio of a layer", nu, fits, "0.5", "")?;
            }
            Body::Cone(angle) => {
                let fits = angle > 0.0 && angle < 0.5 * PI;
                range("half angle", angle, fits, "in (0, π/2) {}", "rad")?;
                let what = "stiffening under a cone";
                range(what, stiffening, stiffening == 0.0, "0", "")?;
            }
        }
        Ok(Self {
            loading,
            body,
            poisson_ratio,
            stiffening,
        })
    }

    /// A slab that is compressed and slides on its plates, of incompressible matter that does not stiffen.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn slab(area: SquareMetres, thickness: Metres) -> Result<Self, LoopParameterError> {
        let loading = Loading {
            area_m2: Some(area.0),
            thickness_m: Some(thickness.0),
            ..Loading::new(LoadingKind::Compression)
        };
        Self::new(loading, INCOMPRESSIBLE, 0.0)
    }

    /// The loading and its sizes, as given.
    #[must_use]
    pub const fn loading(&self) -> &Loading {
        &self.loading
    }

    /// γ, m: force over M ∗ de, for a modulus M.
    #[must_use]
    pub fn shape(&self, modulus: Modulus) -> f64 {
        let (nu, ratio) = (self.poisson_ratio, 2.0 * (1.0 + self.poisson_ratio));
        let (natural, shape) = match self.body {
            Body::Slab { area, thickness } => {
                let plain = area / thickness;
                // 2S² = A/(2πh²)
                let bonded = || 1.0 + area / (2.0 * PI * thickness * thickness);
                match (self.loading.kind.modulus(), self.loading.bonded) {
                    (Modulus::Young, true) => (Modulus::Young, plain * bonded()),
                    (modulus, _) => (modulus, plain),
                }
            }
            Body::Punch(radius) => (Modulus::Shear, 4.0 * radius / (1.0 - nu)),
            Body::Sphere { radius, .. } => (Modulus::Shear, 8.0 * radius / (3.0 * (1.0 - nu))),
            Body::Cone(angle) => {
                let shape = 4.0 * libm::tan(angle) * CONE_LENGTH / (PI * (1.0 - nu));
                (Modulus::Shear, shape)
            }
        };
        match (natural, modulus) {
            (Modulus::Shear, Modulus::Young) => shape / ratio,
            (Modulus::Young, Modulus::Shear) => shape * ratio,
            (Modulus::Shear, Modulus::Shear) | (Modulus::Young, Modulus::Young) => shape,
        }
    }

    /// ℓ of the nominal strain, m: the thickness of a slab or layer, the radius of a punch or sphere; none for a cone, whose
    /// strain does not grow with its depth.
    #[must_use]
    pub const fn length(&self) -> Option<Metres> {
        match self.body {
            Body::Slab { thickness, .. } => Some(Metres(thickness)),
            Body::Sphere {
                layer: Some(thickness),
                ..
            } => Some(Metres(thickness)),
            Body::Punch(radius) | Body::Sphere { radius, .. } => Some(Metres(radius)),
            Body::Cone(_) => None,
        }
    }

    /// ε = δ/ℓ; 0 under a cone.
    #[must_use]
    pub fn strain(&self, depth: Metres) -> f64 {
        self.length().map_or(0.0, |length| depth.0 / length.0)
    }

    /// Area and thickness of a slab; `None` for other loadings.
    #[must_use]
    pub const fn slab_sizes(&self) -> Option<(SquareMetres, Metres)> {
        match self.body {
            Body::Slab { area, thickness } => Some((SquareMetres(area), Metres(thickness))),
            Body::Punch(_) | Body::Sphere { .. } | Body::Cone(_) => None,
        }
    }

    /// e; `None` if it is δ itself.
    #[must_use]
    pub fn depth_map(&self) -> Option<DepthMap<f64>> {
        let mut terms = [0.0; 6];
        let scale = match self.body {
            Body::Slab { .. } | Body::Punch(_) => {
                if self.stiffening == 0.0 {
                    return None;
                }
                terms[0] = 1.0;
                1.0
            }
            Body::Sphere { radius, layer } => {
                // χ = (R/h)·u
                let slender = layer.map_or(0.0, |thickness| radius / thickness);
                let mut power = 1.0;
                let factors = if self.loading.bonded {
                    BONDED_LAYER
                } else {
                    FREE_LAYER
                };
                for (term, factor) in terms[1..].iter_mut().zip(factors) {
                    *term = factor * power;
                    power *= slender;
                }
                radius
            }
            Body::Cone(_) => {
                terms[2] = 1.0;
                CONE_LENGTH
            }
        };
        let per_m = self
            .length()
            .map_or(0.0, |length| self.stiffening / length.0);
        Some(DepthMap {
            per_scale: 1.0 / scale,
            terms,
            stiffening_per_m: per_m,
        })
    }
}

/// e, a static map of the depth, m for m: 0 at 0, growing and convex.
///
/// ```text
/// e(δ) = δ·(c₀ + c₁u + … + c₅u⁵)·(exp(qδ) − 1)/(qδ),        u = √(δ/s)
/// ```
/// Its slope grows with the depth. *Cost*: a root and five multiply-adds; an exponential and a division if q > 0. Single and
/// double precision each compute the same bits on host and target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMap<F> {
    per_scale: F,
    terms: [F; 6],
    stiffening_per_m: F,
}

impl<F: Real> DepthMap<F> {
    /// 1/s in 1/m, c₀ to c₅, and q in 1/m, as received over a line; `None` unless
    /// [`new`](Self::new) accepts them.
    #[must_use]
    pub fn of(numbers: [F; 8]) -> Option<Self> {
        let [per_scale, terms @ .., stiffening_per_m] = numbers;
        let sum = terms.iter().fold(F::ZERO, |sum, &term| sum + term);
        let good = |number: F| number.is_finite() && number >= F::ZERO;
        let all = numbers.into_iter().all(good) && per_scale > F::ZERO && sum > F::ZERO;
        all.then_some(Self {
            per_scale,
            terms,
            stiffening_per_m,
        })
    }

    /// 1/s in 1/m, c₀ to c₅, and q in 1/m.
    ///
    /// # Errors
    /// Each must be finite and at least 0, s and the sum of c above 0, in the precision of the loop too.
    pub fn new(numbers: [f64; 8]) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        for number in numbers {
            checks.not_negative("number of a depth map", number, "");
        }
        let [per_scale, .., stiffening_per_m] = numbers;
        checks.positive("scale of a depth map", per_scale, "1/m");
        let sum = numbers[1..7].iter().sum();
        checks.positive("sum of the terms of a depth map", sum, "");
        let mut rounded = |value| checks.rounded("number of a depth map", value, "");
        let map = Self {
            per_scale: rounded(per_scale),
            terms: core::array::from_fn(|n| rounded(numbers[n + 1])),
            stiffening_per_m: rounded(stiffening_per_m),
        };
        checks.done().map(|()| map)
    }

    /// 1/s in 1/m, c₀ to c₅, and q in 1/m.
    #[must_use]
    pub fn numbers(&self) -> [F; 8] {
        let mut numbers = [self.per_scale; 8];
        numbers[1..7].copy_from_slice(&self.terms);
        numbers[7] = self.stiffening_per_m;
        numbers
    }

    /// e of a depth of at least 0, m; NaN gives NaN, and a depth below 0 is returned unchanged.
    #[must_use]
    #[inline(never)]
    pub fn at(&self, depth: F) -> F {
        if depth <= F::ZERO {
            return depth;
        }
        let [c0, c1, c2, c3, c4, c5] = self.terms;
        let u = root(depth * self.per_scale);
        let plain = depth * (c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))));
        if self.stiffening_per_m > F::ZERO {
            plain * growth(self.stiffening_per_m * depth)
        } else {
            plain
        }
    }
}

/// √x of a number of at least 0, within 2 units of the last place of a normal one: Newton's steps for 1/√x, and one for the root.
#[inline]
fn root<F: Real>(x: F) -> F {
    let (half, three_halves) = (F::from_f64(0.5), F::from_f64(1.5));
    let half_x = half * x;
    let step = |y: F| y * (three_halves - half_x * y * y);
    // The error of 3.5 % falls to 5e-6 and, in double precision, 3e-11.
    let mut y = step(step(x.rough_inverse_root()));
    if !F::COMPENSATED {
        y = step(y);
    }
    let rough = x * y;
    rough + half * y * (x - rough * rough)
}

/// φ(x) = (eˣ − 1)/x, x at least 0: Taylor's series where the terms behind its eighth are lost; further out at x/16ⁿ, and
/// e²ʸ − 1 = m(m + 2), m = eʸ − 1, four times n.
#[inline]
fn growth<F: Real>(x: F) -> F {
    let number = F::from_f64;
    let near = if F::COMPENSATED {
        number(0.5)
    } else {
        number(1.0 / 32.0)
    };
    let (mut y, mut sixteenths) = (x, 0);
    while y > near && sixteenths < SIXTEENTHS_MAX {
        y = number(1.0 / 16.0) * y;
        sixteenths += 1;
    }
    let over = |factorial: f64| number(1.0 / factorial);
    let far = over(120.0) + y * (over(720.0) + y * (over(5040.0) + y * over(40_320.0)));
    let phi = F::ONE + y * (over(2.0) + y * (over(6.0) + y * (over(24.0) + y * far)));
    if sixteenths == 0 {
        return phi;
    }
    let mut m = y * phi;
    for _ in 0..4 * sixteenths {
        m = m * (m + number(2.0));
    }
    m / x
}

/// Most divisions by 16 in [`growth`]: beyond, both precisions have overflowed.
const SIXTEENTHS_MAX: u32 = 4;

impl DepthMap<f64> {
    /// This map in the precision of a loop.
    ///
    /// # Errors
    /// If a number overflows or vanishes there.
    pub fn rounded<F: Real>(&self) -> Result<DepthMap<F>, LoopParameterError> {
        DepthMap::new(self.numbers())
    }

    /// e'(δ), without unit, for a depth of at least 0.
    #[must_use]
    pub fn slope(&self, depth: f64) -> f64 {
        let u = libm::sqrt(depth.max(0.0) * self.per_scale);
        // d(δ·uⁿ)/dδ = (1 + n/2)·uⁿ
        let (mut plain, mut rate, mut power) = (0.0, 0.0, 1.0);
        for (n, term) in self.terms.iter().enumerate() {
            plain += term * power;
            rate += (1.0 + 0.5 * n as f64) * term * power;
            power *= u;
        }
        let x = self.stiffening_per_m * depth;
        if x <= f64::EPSILON {
            return rate;
        }
        // (δ·p·φ)' = (δ·p)'·φ + p·(eˣ − φ)
        let (phi, grown) = (libm::expm1(x) / x, libm::exp(x));
        if grown.is_infinite() {
            return grown;
        }
        rate * phi + plain * (grown - phi)
    }

    /// The largest depth, m, up to a kilometre, at which the slope of e is at most this, to a
    /// relative 1e-12; 0 if every slope is larger.
    #[must_use]
    pub fn depth_of_slope(&self, slope: f64) -> f64 {
        let (mut low, mut high) = (libm::log(1e-12), libm::log(1e3));
        if self.slope(libm::exp(low)) > slope {
            return 0.0;
        }
        for _ in 0..64 {
            let middle = 0.5 * (low + high);
            // Beyond its exponential a slope is infinite, and above.
            if self.slope(libm::exp(middle)) <= slope {
                low = middle;
            } else {
                high = middle;
            }
        }
        libm::exp(low)
    }

    /// The depth of at least 0 at which e has a value of at least 0, m. Newton's steps from above, where a convex e is
    /// approached from one side, to the last digits.
    #[must_use]
    pub fn depth(&self, value: f64) -> f64 {
        if value.is_nan() || value <= 0.0 {
            return if value < 0.0 { 0.0 } else { value };
        }
        let mut depth = value;
        // From the scale of the map up to where e is above the value: at most some hundred doublings.
        while self.at(depth) < value && depth.is_finite() {
            depth *= 2.0;
        }
        while self.at(0.5 * depth) > value {
            depth *= 0.5;
        }
        for _ in 0..64 {
            let step = (self.at(depth) - value) / self.slope(depth);
            let next = depth - step;
            // Rounding stands still, or steps back.
            if next.is_nan() || next >= depth {
                break;
            }
            depth = next;
        }
        depth
    }
}
