//! The loop of a touch: made of good parameters, judged along the normal, run with a log, here or on a device at a port, where the
//! shape is felt in a real hand, or in that of an emulated board.

use super::{
    TOUCH_BOX_HIGH, TOUCH_BOX_LOW, TOUCH_CIRCLE_START, TOUCH_MUST_BE_PASSIVE, TOUCH_WAY,
    TouchExperiment,
    device::{HandEnergy, HeldAxes, TouchTick, depth},
    report::PostureVerdict,
    shape::{Grip, HandPath, TouchShape, Touched, per_axis},
};
use crate::{
    experiment::{
        kind::{Experiment, conducts},
        reading::metadata,
        trial::no_law_there,
    },
    judge::{Published, Report},
};
use haptic_analysis::Dynamics;
use haptic_devices::haply::HaplyPlane;
use haptic_document::{
    Failure, bad_input,
    parameters::{DEVICE, TISSUE_IN_LOG},
};
use haptic_judge::preflight::Preflight;
use haptic_link::LoopMode;
use haptic_loop::{
    Contact, Controller, SpringDamper,
    plant::{Axes, MassMatrix, Sensed},
    units::Kilograms,
};
use haptic_remote::wire_surface;
use haptic_run::{
    Ran, Watched,
    device::LinkedName,
    remote::{RemoteDevice, RemoteLaw, RemoteRun, portable},
    run_logged,
};
use haptic_trial::{
    advice::parameter,
    preflight::{Findings, PreflightVerdict, note_findings},
    simulate::SimulatedLoop,
};
use nalgebra::SVector;
use std::collections::BTreeMap;

/// A loop made of good parameters.
struct Parts<const D: usize> {
    controller: Controller<f64, D, Touched<D>>,
    device: Sensed<HeldAxes<D>>,
    samples: u64,
}

/// Deeper than this at the start is a blow, m: more than rounding.
const START_MOST_M: f64 = 1e-9;

impl Experiment for TouchExperiment {
    fn check(&self) -> Result<u64, Failure> {
        match self.axes {
            3 => self.checked::<3>(),
            _ => self.checked::<2>(),
        }
    }

    fn sample_time_s(&self) -> f64 {
        self.sample_time().0
    }

    fn axes(&self) -> usize {
        self.axes
    }

    /// Metadata of a touch besides its document: the place of the shape.
    fn metadata(&self) -> BTreeMap<String, String> {
        let (key, numbers) = match &self.shape {
            TouchShape::Plane { normal, .. } => ("normal", normal),
            TouchShape::Ball(ball) => ("centre_m", &ball.centre_m),
        };
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let mut metadata = metadata("touch", &self.conduct, self.scheme, &self.safety);
        if self.conduct.remote.is_some() {
            // The simulated hand of the document is not used.
            metadata.insert("hand".to_owned(), "real".to_owned());
        }
        metadata.insert(key.to_owned(), numbers.join(" "));
        metadata.extend(
            self.matter
                .file()
                .map(|file| (TISSUE_IN_LOG.to_owned(), file)),
        );
        metadata
    }

    conducts!();

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        match self.axes {
            3 => self.run_in::<3>(watched),
            _ => self.run_in::<2>(watched),
        }
    }

    /// Refuses a bad start on simulated axes: where a device begins, only the device knows.
    fn check_start(&self) -> Result<(), Failure> {
        match self.axes {
            _ if self.conduct.remote.is_some() => Ok(()),
            3 => self.outside(&self.parts::<3>()?),
            _ => self.outside(&self.parts::<2>()?),
        }
    }
}

impl TouchExperiment {
    fn outside<const D: usize>(&self, parts: &Parts<D>) -> Result<(), Failure> {
        let shape = self.shape.of::<D>()?;
        let begins = depth(&shape, parts.device.device().position_m().as_slice());
        if begins <= START_MOST_M {
            return Ok(());
        }
        Err(bad_input!(
            "the device begins {begins:.3e} m deep in the shape, which would be a blow: let the hand begin outside, \
             by {TOUCH_WAY} or {TOUCH_CIRCLE_START}, or move the shape"
        ))
    }

    fn run_in<const D: usize>(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        if let Some(remote) = &self.conduct.remote {
            return self.run_on::<D>(remote, watched);
        }
        let mut parts = self.parts::<D>()?;
        self.outside(&parts)?;
        let postures = self.postures::<D>(parts.samples)?;
        let (verdict, posture) = postures.worse(self.dynamics(), 0)?;
        let mut metadata = self.metadata();
        note_findings(&mut metadata, "preflight", &verdict);
        note_findings(&mut metadata, "preflight", &posture);
        let schedule = self.schedule(parts.samples);
        let mut world = SimulatedLoop::new(&mut parts.controller, &mut parts.device);
        let ran = run_logged(
            &mut world,
            schedule,
            (watched.request, metadata),
            watched.supervisor,
        )?;
        drop(world);
        let ran = Ran {
            // Nothing can break, so it is only noted.
            preflight: Some(verdict),
            ..ran
        };
        let energy: HandEnergy = parts.device.device().energy();
        self.publish::<D>(ran, Some(energy), posture)
    }

    fn checked<const D: usize>(&self) -> Result<u64, Failure> {
        match &self.conduct.remote {
            Some(_) => {
                self.check_on::<D>()?;
                Ok(self.loop_of::<D>()?.1)
            }
            None => Ok(self.parts::<D>()?.samples),
        }
    }

    /// The loop, and its number of samples.
    fn loop_of<const D: usize>(&self) -> Result<(Controller<f64, D, Touched<D>>, u64), Failure> {
        let samples = self.samples()?;
        let shape = self.shape.of::<D>()?;
        let look = self.look(samples);
        let (k, b) = (look.stiffness_n_per_m, look.dissipation_n_s_mu_per_m);
        let law = SpringDamper::new(k, b, look.operator()?).map_err(parameter)?;
        let touched = Contact::behind(shape, law).with_depth_map(self.matter.depth_map());
        Ok((Controller::new(touched, self.chain()?), samples))
    }

    fn parts<const D: usize>(&self) -> Result<Parts<D>, Failure> {
        let t = self.sample_time();
        let (controller, samples) = self.loop_of::<D>()?;
        let shape = self.shape.of::<D>()?;
        let axes = per_axis::<D>(&self.mass_kg).map(|mass| self.axis(mass));
        let axes = Axes::new(axes).map_err(parameter)?;
        let device = HeldAxes::new(axes, self.path.clone(), self.grip, shape, &self.device);
        Ok(Parts {
            controller,
            device: (self.sensors).and_force_before(device, self.force_sensor, t)?,
            samples,
        })
    }

    /// Refuses what a device at a port cannot do.
    fn check_on<const D: usize>(&self) -> Result<(), Failure> {
        if self.must_be_passive {
            return Err(bad_input!(
                "{TOUCH_MUST_BE_PASSIVE} is for the simulated device, where the energy of the hand is known: omit it with {DEVICE}"
            ));
        }
        match self.plane().filter(|_| D == 2) {
            Some(plane) => self.reached(&plane).map(drop),
            None => Ok(()),
        }
    }

    /// Runs it there; a loop here has limits on both sides.
    fn run_on<const D: usize>(
        &self,
        remote: &RemoteDevice,
        watched: Watched<'_>,
    ) -> Result<Published<Report>, Failure> {
        self.check_on::<D>()?;
        let (mut controller, samples) = self.loop_of::<D>()?;
        let shape = self.shape.of::<D>()?;
        let postures = self.postures::<D>(samples)?;
        // A hand that may let go at any time counts as none.
        let dynamics = Dynamics {
            hand_stiffness_n_per_m: 0.0,
            ..self.dynamics()
        };
        let (_, posture) = postures.worse(dynamics, 0)?;
        let mut metadata = self.metadata();
        note_findings(&mut metadata, "preflight", &posture);
        let look = |device, line| Ok(Findings::Loop(postures.worse(device, line)?.0));
        let blank = |_| TouchTick::unknown(shape);
        let law = self.law_there::<D>(remote, samples)?;
        let run = RemoteRun {
            preflight: Some(&look),
            force_unstable: self.conduct.force_unstable,
            dynamics: Some(dynamics),
            metadata,
            ..RemoteRun::new(remote, law, self.schedule(samples), &blank, watched.request)
        };
        let ran = run.run(&mut controller, watched.supervisor)?;
        self.publish::<D>(ran, None, posture)
    }

    /// Largest depth to which the hand leads the device, m: that of its largest force, and with a spring no farther than its path.
    fn deepest<const D: usize>(&self) -> Result<f64, Failure> {
        let crept = |force_n| self.matter.crept(force_n, self.duration_s);
        if self.conduct.remote.is_some() {
            return Ok(crept(self.force_limit_n));
        }
        let at = |tick: u64| {
            let time_s = tick as f64 * self.sample_time().0;
            std::array::from_fn::<f64, D, _>(|axis| self.path.at(time_s, axis))
        };
        let samples = self.samples()?;
        let most =
            |of: &dyn Fn([f64; D]) -> f64| (0..samples).map(|n| of(at(n))).fold(0.0, f64::max);
        Ok(match self.grip {
            Grip::Spring(stiffness) => {
                let shape = self.shape.of::<D>()?;
                let path_m = most(&|point| depth(&shape, &point));
                crept(stiffness * path_m).min(path_m)
            }
            Grip::Force => crept(most(&|force| SVector::from(force).norm())),
        })
    }

    /// Settings for the device: limits, shape and law of its own loop, and the plant of an emulated one. Its hand is that of the file as far as
    /// a board has one: a spring to 0, or a push along the first axis.
    fn law_there<const D: usize>(
        &self,
        remote: &RemoteDevice,
        samples: u64,
    ) -> Result<RemoteLaw, Failure> {
        let push_n = match (self.grip, &self.path) {
            (Grip::Force, HandPath::WayPoints(rows)) => {
                let last = rows.last().and_then(|(_, force)| force.first());
                last.copied().unwrap_or(0.0)
            }
            _ => 0.0,
        };
        let (limits, rate) = (self.norm_and_box(), self.force_rate_limit_n_per_s);
        let none = no_law_there(limits, rate, &self.safety, &self.lightest(), push_n);
        if remote.loop_mode == LoopMode::Host {
            return Ok(none);
        }
        let look = self.look(samples);
        Ok(RemoteLaw {
            stiffness_n_per_m: look.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: look.dissipation_n_s_mu_per_m,
            order: look.order.get(),
            one_sided: true,
            depth_map: self.matter.depth_map(),
            surface: Some(wire_surface(&self.shape.of::<D>()?)),
            operator: portable(&look.operator()?)?,
            ..none
        })
    }
}

/// The loop in the lightest and the heaviest posture.
#[derive(Debug)]
struct Postures<'a> {
    loops: Preflight<'a>,
    masses_kg: [f64; 2],
}

impl Postures<'_> {
    /// The verdict of the worse of both, and its mass, with this device but for the mass and `line` samples of delay on a line.
    fn worse(
        &self,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<(PreflightVerdict, PostureVerdict), Failure> {
        let [least, most] = self.masses_kg;
        let judge = |mass_kg: f64| -> Result<_, Failure> {
            let dynamics = Dynamics {
                mass_kg,
                ..dynamics
            };
            // Not every motion: a shape in the plane is no function of one depth.
            Ok((self.loops.verdict(dynamics, line)?, mass_kg))
        };
        let (light, heavy) = (judge(least)?, judge(most)?);
        // Without an edge any margin is there; unstable without one none is.
        let rank = |verdict: &PreflightVerdict| {
            let none = if verdict.stable { f64::INFINITY } else { 0.0 };
            (verdict.stable, verdict.margin.unwrap_or(none))
        };
        let heavy_is_worse = rank(&heavy.0) < rank(&light.0);
        let (verdict, judged_mass_kg) = if heavy_is_worse { heavy } else { light };
        let posture = PostureVerdict {
            effective_mass_least_kg: least,
            effective_mass_most_kg: most,
            judged_mass_kg,
        };
        Ok((verdict, posture))
    }
}

impl TouchExperiment {
    /// Least and largest effective mass along the normals that come up, kg: of axes that are masses of their own those of the
    /// axes themselves, unless there is one normal alone; of arms those of their postures in the box.
    fn effective_masses<const D: usize>(&self) -> Result<[f64; 2], Failure> {
        let masses = per_axis::<D>(&self.mass_kg);
        if let Some(plane) = self.plane() {
            let mean = libm::pow(masses.iter().product::<f64>(), 1.0 / D as f64);
            return Ok(self.reached(&plane)?.map(|mass| mean * mass));
        }
        let TouchShape::Plane { normal, .. } = &self.shape else {
            return Ok(self.masses());
        };
        let matrix = MassMatrix::of_axes(masses.map(Kilograms)).map_err(Failure::input)?;
        let along = matrix.along(&SVector::from(per_axis::<D>(normal)));
        Ok([along.map_err(Failure::input)?.0; 2])
    }

    /// The plane of a 2DIY.
    fn plane(&self) -> Option<HaplyPlane> {
        match &self.conduct.remote.as_ref()?.name {
            LinkedName::Foreign(name) => name.plane(),
            LinkedName::Serial(_) => None,
        }
    }

    /// Least and largest mass in the box, or in the middle of the plane without one, for 1 kg in its centre.
    fn reached(&self, plane: &HaplyPlane) -> Result<[f64; 2], Failure> {
        let corners = self.workspace_m.as_ref();
        let (low_m, high_m) = corners.map_or(HaplyPlane::HANDY_M, |[low_m, high_m]| {
            (per_axis(low_m), per_axis(high_m))
        });
        plane.masses(low_m, high_m).map_err(|error| {
            Failure::input_with_advice(
                format_args!("the box is not within reach of the 2DIY: {error}"),
                format_args!("change {TOUCH_BOX_LOW} or {TOUCH_BOX_HIGH}"),
            )
        })
    }

    /// Loops and masses for the pre-flight.
    fn postures<const D: usize>(&self, samples: u64) -> Result<Postures<'_>, Failure> {
        let look = self.look(samples);
        Ok(Postures {
            loops: match self.matter.depth_map() {
                None => look,
                map => look.at_depth(map, self.deepest::<D>()?),
            },
            masses_kg: self.effective_masses::<D>()?,
        })
    }
}
