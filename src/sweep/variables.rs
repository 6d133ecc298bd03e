//! What can be swept: factors on loads, initial conditions, parameters of a load file.

use rom_runtime::{LoadCase, Model, State};

/// One thing that differs from case to case.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// Factor on all loads of the case.
    Scale,
    /// Factor on the loads of one point, by index.
    ScalePoint(u32),
    /// Component of the velocity or angular velocity of A in A at t = 0: 0 to 5.
    Velocity(usize),
    /// Component of the position of A in G at t = 0.
    Position(usize),
    /// Amplitude of a mode at t = 0, by place.
    Amplitude(usize),
    /// Rate of a mode at t = 0, by place.
    Rate(usize),
    /// Parameter of the file of load cases.
    Parameter(String),
}

impl Variable {
    /// From its name.
    ///
    /// # Errors
    /// What was found and what the model has.
    pub fn parse(name: &str, model: &Model) -> Result<Self, String> {
        if name == "scale" {
            return Ok(Self::Scale);
        }
        let Some((kind, rest)) = name.split_once('.') else { return Ok(Self::Parameter(name.to_owned())) };
        let axis = || {
            ["x", "y", "z"]
                .iter()
                .position(|axis| *axis == rest)
                .ok_or_else(|| format!("{name}: expected {kind}.x, {kind}.y or {kind}.z"))
        };
        let mode = || {
            let numbers = &model.data().modes.number;
            let found = numbers.iter().position(|number| number.to_string() == rest);
            found.ok_or_else(|| format!("{name}: the model has no elastic mode {rest}; it has: {numbers:?}"))
        };
        match kind {
            "scale" => {
                let point = model.point(rest).map_err(|e| format!("{name}: {e}"))?;
                Ok(Self::ScalePoint(point as u32))
            }
            "v_A" => axis().map(Self::Velocity),
            "w_A" => axis().map(|axis| Self::Velocity(axis + 3)),
            "r_G" => axis().map(Self::Position),
            "q" => mode().map(Self::Amplitude),
            "q_dot" => mode().map(Self::Rate),
            _ => Err(format!(
                "{name} is nothing that can be swept; expected scale, scale.POINT, v_A.x, w_A.x, r_G.x, q.MODE, q_dot.MODE or \
                 a parameter of a file of load cases"
            )),
        }
    }

    /// Changes the loads of a case; those of the equilibrium stay.
    pub fn change_loads(&self, value: f64, case: &mut LoadCase) {
        for load in &mut case.loads {
            let scaled = match self {
                Self::Scale => true,
                Self::ScalePoint(point) => load.point == *point,
                _ => false,
            };
            if scaled {
                load.force = load.force.map(|f| f * value);
                load.moment = load.moment.map(|m| m * value);
            }
        }
        if matches!(self, Self::Scale) {
            for load in &mut case.distributed {
                load.force.iter_mut().chain(&mut load.moment).for_each(|x| *x *= value);
            }
        }
    }

    /// Changes the modes of a state.
    fn change_modes(&self, value: f64, state: &mut State) {
        match self {
            Self::Amplitude(mode) => state.q[*mode] = value,
            Self::Rate(mode) => state.q_dot[*mode] = value,
            _ => {}
        }
    }
}

/// Changes a state at t = 0: what the model says of A comes out as asked for, whatever axes its equations are written in.
pub fn change_start(model: &Model, variables: &[(Variable, f64)], state: &mut State) {
    variables.iter().for_each(|(variable, value)| variable.change_modes(*value, state));
    // Angular velocity first: that of the origin depends on it.
    for (variable, value) in variables {
        if let Variable::Velocity(axis @ 3..) = variable {
            state.beta_star[*axis] += value - model.rigid_output(state).w_a[axis - 3];
        }
    }
    for (variable, value) in variables {
        match variable {
            Variable::Velocity(axis @ 0..3) => {
                state.beta_star[*axis] += value - model.rigid_output(state).v_a[*axis];
            }
            Variable::Position(axis) => state.position[*axis] += value - model.rigid_output(state).r_g[*axis],
            _ => {}
        }
    }
    state.accelerations_known = false;
}

/// Parses `--sweep`: `name=a,b,c`, `name=0..20` for whole numbers or `name=a..b:n` for `n` even steps, ends included.
///
/// # Errors
/// What was found and what is accepted.
pub fn values(text: &str) -> Result<(String, Vec<f64>), String> {
    let expected =
        || format!("expected name=a,b,c or name=0..20 or name=0.5..1.5:11 (eleven values), found {text:?}");
    let (name, list) = text.split_once('=').ok_or_else(expected)?;
    let (name, list) = (name.trim(), list.trim());
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let values: Option<Vec<f64>> = match list.split_once("..") {
        None => list.split(',').map(number).collect(),
        Some((first, rest)) => {
            let (last, count) = match rest.split_once(':') {
                Some((last, count)) => (number(last), count.trim().parse::<u32>().ok().filter(|n| *n > 1)),
                None => {
                    let steps = number(first).zip(number(rest)).map(|(a, b)| b - a);
                    let whole = steps.filter(|n| (0.0..1e6).contains(n) && n.fract() == 0.0);
                    (number(rest), whole.map(|n| n as u32 + 1))
                }
            };
            number(first).zip(last).zip(count).map(|((first, last), count)| {
                let at = |i: u32| first + (last - first) * f64::from(i) / f64::from((count - 1).max(1));
                (0..count).map(|i| if i > 0 && i + 1 == count { last } else { at(i) }).collect()
            })
        }
    };
    match values {
        Some(values) if !name.is_empty() => Ok((name.to_owned(), values)),
        _ => Err(expected()),
    }
}

/// Cases from a table: names on the first line, a line of numbers for each case, between commas.
///
/// # Errors
/// The line, what was found and what is accepted.
pub fn table(text: &str) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, head) = lines.next().ok_or("the table is empty, expected names on its first line")?;
    let names: Vec<String> = head.split(',').map(|name| name.trim().to_owned()).collect();
    if let Some(i) = (0..names.len()).find(|&i| names[i].is_empty() || names[..i].contains(&names[i])) {
        return Err(format!("line 1: {:?} is no name, or is there twice", names[i]));
    }
    let mut rows = Vec::new();
    for (number, line) in lines {
        let row: Vec<&str> = line.split(',').map(str::trim).collect();
        if row.len() != names.len() {
            return Err(format!("line {}: {} numbers, expected {}", number + 1, row.len(), names.len()));
        }
        let parse = |x: &&str| {
            x.parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(|| format!("line {}: expected a finite number, found {x:?}", number + 1))
        };
        rows.push(row.iter().map(parse).collect::<Result<_, _>>()?);
    }
    if rows.is_empty() {
        return Err("the table has no cases, expected a line of numbers for each".to_owned());
    }
    Ok((names, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_ranges_and_even_steps() {
        assert_eq!(values("scale=1, 2.5"), Ok(("scale".to_owned(), vec![1.0, 2.5])));
        assert_eq!(values("q.1=-1..1").unwrap().1, [-1.0, 0.0, 1.0]);
        assert_eq!(values("v_A.x=0..1:5").unwrap().1, [0.0, 0.25, 0.5, 0.75, 1.0]);
        for wrong in [
            "scale",
            "=1",
            "scale=",
            "scale=1,,2",
            "scale=a",
            "scale=0..1:1",
            "scale=0..0.5",
            "scale=nan",
            "x=3..1",
        ] {
            assert!(values(wrong).unwrap_err().contains("expected name="), "{wrong}");
        }
    }

    #[test]
    fn tables() {
        let (names, rows) = table("scale, v_A.x\n1,2\n\n3,4e0\n").unwrap();
        assert_eq!(
            (names, rows),
            (vec!["scale".to_owned(), "v_A.x".to_owned()], vec![vec![1.0, 2.0], vec![3.0, 4.0]])
        );
        for (text, word) in [
            ("", "empty"),
            ("a\n", "no cases"),
            ("a,a\n1,2", "twice"),
            ("a,b\n1", "line 2: 1 numbers"),
            ("a\nx", "line 2"),
        ] {
            assert!(table(text).unwrap_err().contains(word), "{text}");
        }
    }
}
