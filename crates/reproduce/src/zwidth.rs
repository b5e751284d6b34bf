//! Figure 4.3: the largest stable stiffness, simulated, over theory.

use super::figure::{Curve, Figure, Panel, per_order, share_axes};
use super::walls::{ALPHA, BETA, border};
use super::{DELTA, Kind, ORDERS, SAMPLE_TIME_S};
use fracdiff::{Order, Seconds};
use haptic_experiment::{Failure, Imperfections, Sensors, TrialPlan, ZWidth, dissertation_device};
use haptic_figure::Look;
use std::sync::atomic::AtomicBool;

pub(super) fn zwidth(stop: &AtomicBool) -> Result<Figure, Failure> {
    let mut panels = vec![
        panel("ideal device", false, stop)?,
        panel("realistic device", true, stop)?,
    ];
    share_axes(&mut panels);
    let enlarged = enlarged(&panels);
    panels.extend(enlarged);
    Ok(Figure {
        id: "4.3",
        title: "largest stable stiffness, simulated, over theory",
        conditions: "A₃; markers: simulated, 1 N for 5 s, stable if within 0.1 mm rms over the last 0.4 s; lines: \
                     theory of the ideal device\n\
                     realistic (our choice): 1 µm encoder, 0.05 N friction, 1 ms delay, 1 ms current lag; markers \
                     that would cover others are left out"
            .to_owned(),
        columns: 2,
        panels,
    })
}

/// The border of theory and the markers of a simulated device.
fn panel(caption: &str, realistic: bool, stop: &AtomicBool) -> Result<Panel, Failure> {
    let imperfections = if realistic {
        Imperfections {
            friction_n: 0.05,
            delay_s: 1e-3,
            current_lag_s: 1e-3,
            sensors: Sensors {
                encoder_resolution_m: 1e-6,
                ..Imperfections::NONE.sensors
            },
        }
    } else {
        Imperfections::NONE
    };
    let orders = ORDERS.map(Order::new).into_iter().collect::<Result<_, _>>();
    let experiment = ZWidth {
        device: imperfections.on(dissertation_device(Seconds(SAMPLE_TIME_S))),
        sensors: imperfections.sensors,
        one_sided: false,
        scheme: Kind::Muir.scheme(),
        orders: orders.map_err(Failure::input)?,
        points: 21,
        plan: TrialPlan::DISSERTATION,
        remote: None,
    };
    let report = experiment.run(&|_| {}, stop, &|_| {})?;
    let mut curves = per_order(&ORDERS, 0, Look::Line, |mu| {
        border(Kind::Muir, mu, DELTA, 0.0)
    })?;
    for (colour, order) in report.orders.iter().enumerate() {
        curves.push(Curve {
            name: format!("simulated, μ = {}", order.order),
            // One entry with the line of theory.
            legend: format!("μ = {}", order.order),
            points: order.boundary.iter().map(|p| (p.beta, p.alpha)).collect(),
            look: Look::MarkersApart,
            colour,
        });
    }
    Ok(Panel {
        caption: caption.to_owned(),
        x: BETA,
        y: ALPHA,
        curves,
        repeats: false,
    })
}

/// The part of the plane that the realistic device, the second, reaches.
fn enlarged(panels: &[Panel]) -> Vec<Panel> {
    let simulated = |panel: &Panel| {
        let curves = panel.curves.iter().cloned();
        let curves = curves.filter(|curve| curve.look == Look::MarkersApart);
        Panel {
            curves: curves.collect(),
            ..panel.clone()
        }
    };
    let mut reach = [simulated(&panels[1])];
    share_axes(&mut reach);
    let enlarged = |panel: &Panel| Panel {
        caption: format!("{}, enlarged", panel.caption),
        x: reach[0].x,
        y: reach[0].y,
        repeats: true,
        ..panel.clone()
    };
    panels.iter().map(enlarged).collect()
}
