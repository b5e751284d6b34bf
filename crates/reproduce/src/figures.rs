//! The figures of the dissertation, as data and picture.

use super::figure::Figure;
use super::relaxation::relaxation;
use super::responses::{coefficients, environment, sensitivity, transparency};
use super::walls::{passivity, region_matrix, regions};
use super::zwidth::zwidth;
use haptic_experiment::Failure;
use std::sync::atomic::AtomicBool;

type Make = fn(&AtomicBool) -> Result<Figure, Failure>;

/// All figures, in order, each with what makes it. A flag that is set while one is made cuts it short.
pub const FIGURES: [Make; 9] = [
    |_| coefficients(),
    |_| environment(),
    |_| regions(),
    zwidth,
    |_| region_matrix(),
    |_| sensitivity(),
    |_| passivity(),
    |_| transparency(),
    |_| relaxation(),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Panel;
    use std::collections::BTreeMap;

    #[test]
    fn each_order_of_a_figure_has_a_look_of_its_own() {
        for make in [
            coefficients,
            environment,
            sensitivity,
            passivity,
            transparency,
        ] {
            let figure = make().expect("makes");
            let curves = figure.panels.iter().flat_map(|panel| &panel.curves);
            let mut looks: BTreeMap<&str, usize> = BTreeMap::new();
            for curve in curves {
                let colour = *looks.entry(&curve.name).or_insert(curve.colour);
                assert_eq!(colour, curve.colour, "{} of {}", curve.name, figure.id);
            }
            let colours: std::collections::BTreeSet<usize> = looks.values().copied().collect();
            assert_eq!(colours.len(), looks.len(), "figure {}", figure.id);
        }
    }

    #[test]
    fn the_data_of_a_figure_have_a_column_for_each_quantity() {
        let figure = environment().expect("makes");
        let columns = figure.columns();
        assert_eq!(
            columns[2..],
            [
                "omega_rad_s",
                "effective_stiffness_n_per_m",
                "effective_damping_n_s_per_m"
            ]
        );
        for (panel, _, cells) in figure.rows() {
            let filled: Vec<bool> = cells.iter().map(Option::is_some).collect();
            assert_eq!(
                filled,
                [
                    true,
                    panel.starts_with("stiffness"),
                    panel.starts_with("damping")
                ]
            );
        }
        // 7.2 shows the same curves twice and holds them once.
        let figure = Figure {
            panels: vec![
                Panel {
                    repeats: true,
                    ..figure.panels[0].clone()
                },
                figure.panels[1].clone(),
            ],
            ..figure
        };
        assert!(
            figure
                .rows()
                .all(|(panel, _, _)| panel.starts_with("damping"))
        );
    }
}
