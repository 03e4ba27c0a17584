//! Checks of the steps of a program against each other.

use coaxle_node::config::{AxisLimit, Wrong};

use super::{MAX_LOOP_DEPTH, ProgramConfig, Repeat, StepConfig};

/// Checks a program: its velocities keep to its limits, it moves the axis only while it is enabled, and
/// running it for ever takes time.
pub(super) fn program(program: &ProgramConfig) -> Result<(), Wrong> {
    let check = ProgramCheck {
        fastest: program.limits.velocity.get(),
    };
    let start_velocity = program.start_velocity.get();
    check.signed_velocity("start-velocity", start_velocity)?;
    // Endless passes without duration would never reach the end of a cycle.
    if program.repeat == Repeat::Forever && !program.steps.iter().any(takes_time) {
        let expected = "at least one with `repeat = true`";
        return Err(Wrong::of("steps", "none that takes time", expected));
    }
    let twice = program.repeat != Repeat::ONCE;
    // An axis that moves at the start is enabled, as a motion cannot be otherwise.
    check.steps("steps", &program.steps, start_velocity != 0.0, twice, 0)?;
    Ok(())
}

fn takes_time(step: &StepConfig) -> bool {
    match step {
        // Followers may be in sync already.
        StepConfig::Enable(_) | StepConfig::When { .. } => false,
        StepConfig::Dwell { for_s } => for_s.get() > 0.0,
        StepConfig::Loop { steps, .. } => steps.iter().any(takes_time),
        // A move takes time unless the axis is at its target already, which shows only while running: passes are
        // guarded there too.
        StepConfig::MoveAbsolute { .. }
        | StepConfig::MoveRelative { .. }
        | StepConfig::Velocity { .. }
        | StepConfig::Halt {} => true,
    }
}

/// Checks that none of the steps waits for followers.
pub(super) fn no_followers(path: &str, steps: &[StepConfig]) -> Result<(), Wrong> {
    for (i, step) in steps.iter().enumerate() {
        match step {
            StepConfig::When { .. } => {
                let field = format!("{path}[{i}].when");
                let expected = "`followers = { nodes = [...] }` of the axis";
                return Err(Wrong::of(field, "no followers to wait for", expected));
            }
            StepConfig::Loop { steps, .. } => {
                no_followers(&format!("{path}[{i}].loop.steps"), steps)?;
            }
            _ => {}
        }
    }
    Ok(())
}

struct ProgramCheck {
    fastest: f64,
}

impl ProgramCheck {
    /// Checks steps that are run with the axis `enabled` or not, and returns the state that they leave.
    /// Steps that are run more than once also have to fit that state.
    fn steps(
        &self,
        path: &str,
        steps: &[StepConfig],
        enabled: bool,
        twice: bool,
        depth: usize,
    ) -> Result<bool, Wrong> {
        let mut left = enabled;
        for (i, step) in steps.iter().enumerate() {
            left = self.step(&format!("{path}[{i}]"), step, left, depth)?;
        }
        if twice && left != enabled {
            // A second pass suffices: steps that change the state set it, so that every later pass begins as this
            // one.
            return self.steps(path, steps, left, false, depth);
        }
        Ok(left)
    }

    fn step(
        &self,
        path: &str,
        step: &StepConfig,
        enabled: bool,
        depth: usize,
    ) -> Result<bool, Wrong> {
        let moving = |name: &str| require_enabled(&format!("{path}.{name}"), enabled);
        match step {
            StepConfig::Enable(enable) => return Ok(*enable),
            StepConfig::MoveAbsolute { velocity, .. } => {
                moving("move-absolute")?;
                self.speed(&format!("{path}.move-absolute.velocity"), *velocity)?;
            }
            StepConfig::MoveRelative { velocity, .. } => {
                moving("move-relative")?;
                self.speed(&format!("{path}.move-relative.velocity"), *velocity)?;
            }
            StepConfig::Velocity { value, .. } => {
                moving("velocity")?;
                self.signed_velocity(&format!("{path}.velocity.value"), value.get())?;
            }
            StepConfig::Halt {} => moving("halt")?,
            StepConfig::Dwell { .. } | StepConfig::When { .. } => {}
            StepConfig::Loop { count, steps } => {
                let path = format!("{path}.loop");
                // Checked before the recursion goes deeper, whose depth a file could otherwise choose.
                require_depth(&path, depth + 1)?;
                let path = format!("{path}.steps");
                return self.steps(&path, steps, enabled, count.get() > 1, depth + 1);
            }
        }
        Ok(enabled)
    }

    fn speed(&self, field: &str, speed: Option<AxisLimit>) -> Result<(), Wrong> {
        match speed {
            Some(speed) if speed.get() > self.fastest => {
                let expected = format!("at most {}, the limit", self.fastest);
                Err(Wrong::of(field, speed.get(), expected))
            }
            _ => Ok(()),
        }
    }

    fn signed_velocity(&self, field: &str, velocity: f64) -> Result<(), Wrong> {
        // In this direction NaN is refused too.
        if velocity.abs() <= self.fastest {
            return Ok(());
        }
        let expected = format!("{} to {}, the limit", -self.fastest, self.fastest);
        Err(Wrong::of(field, velocity, expected))
    }
}

fn require_enabled(field: &str, enabled: bool) -> Result<(), Wrong> {
    if enabled {
        return Ok(());
    }
    let received = "a motion of an axis that is not enabled";
    Err(Wrong::of(field, received, "`{ enable = true }` before it"))
}

fn require_depth(field: &str, depth: usize) -> Result<(), Wrong> {
    if depth <= MAX_LOOP_DEPTH {
        return Ok(());
    }
    let received = format!("a loop nested {depth} deep");
    Err(Wrong::of(
        field,
        received,
        format_args!("at most {MAX_LOOP_DEPTH}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn refusal(rest: &str) -> String {
        let text = format!("limits = {{ velocity = 10, acceleration = 1, jerk = 1 }}\n{rest}");
        parse::<ProgramConfig>("p.toml", &text)
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn a_motion_needs_an_enabled_axis() {
        let expected = "received a motion of an axis that is not enabled, expected \
                        `{ enable = true }` before it";
        for (rest, field) in [
            ("steps = [{ halt = {} }]", "steps[0].halt"),
            (
                "steps = [{ enable = true }, { enable = false }, \
                 { move-absolute = { position = 1 } }]",
                "steps[2].move-absolute",
            ),
            (
                "start-velocity = 1\nrepeat = true\n\
                 steps = [{ velocity = { value = 1 } }, { enable = false }]",
                "steps[0].velocity",
            ),
            (
                "steps = [{ enable = true }, { loop = { count = 2, steps = [\
                 { move-relative = { distance = 1 } }, { enable = false }] } }]",
                "steps[1].loop.steps[0].move-relative",
            ),
        ] {
            let message = refusal(rest);
            assert!(message.starts_with("p.toml:"), "{message}");
            assert!(
                message.ends_with(&format!(": {field}: {expected}")),
                "{message}"
            );
        }
    }

    #[test]
    fn velocities_keep_to_the_limit() {
        let enabled = |step: &str| refusal(&format!("steps = [{{ enable = true }}, {step}]"));
        let message = enabled("{ velocity = { value = -11.0 } }");
        assert!(
            message
                .ends_with("steps[1].velocity.value: received -11, expected -10 to 10, the limit"),
            "{message}"
        );
        let message = enabled("{ move-absolute = { position = 0, velocity = 11.0 } }");
        assert!(
            message.ends_with(
                "steps[1].move-absolute.velocity: received 11, expected at most 10, the limit"
            ),
            "{message}"
        );
    }

    #[test]
    fn loops_are_nested_only_so_deep() {
        let nested = |depth: usize| {
            let open = "{ loop = { count = 1, steps = [".repeat(depth);
            let close = "] } }".repeat(depth);
            format!("steps = [{open} {{ enable = true }} {close}]")
        };
        let message = refusal(&nested(9));
        assert!(
            message.ends_with("received a loop nested 9 deep, expected at most 8"),
            "{message}"
        );
        let text = format!(
            "limits = {{ velocity = 10, acceleration = 1, jerk = 1 }}\n{}",
            nested(8)
        );
        assert!(parse::<ProgramConfig>("p.toml", &text).is_ok());
    }

    #[test]
    fn what_is_repeated_for_ever_takes_time() {
        let message =
            refusal("repeat = true\nsteps = [{ enable = true }, { dwell = { for-s = 0 } }]");
        assert!(
            message.ends_with(
                "steps: received none that takes time, expected at least one with `repeat = true`"
            ),
            "{message}"
        );
    }

    #[test]
    fn repeat_is_yes_no_or_a_count() {
        for bad in ["0", "-1", "'often'", "1.5"] {
            let message = refusal(&format!("repeat = {bad}"));
            assert!(message.starts_with("p.toml:2:10: repeat: "), "{message}");
            assert!(
                message.ends_with("expected true, false, or a count from 1 to 4294967295"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_step_is_one_thing_with_known_fields() {
        assert!(refusal("steps = [{ jump = {} }]").contains("received \"jump\""));
        assert!(refusal("steps = [{ halt = { hard = true } }]").contains("`hard`"));
    }
}
