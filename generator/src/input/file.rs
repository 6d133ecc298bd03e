//! The structure file as written: tables and keys. What they mean together is checked elsewhere.

use schemars::JsonSchema;
use schemars::{Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;
use toml::de::DeValue;

use super::course::CourseFile;
use super::damping::DampingFile;
use super::equilibrium::{EquilibriumFile, GravityFile};
use super::internal_loads::InternalLoadsFile;
use super::loads::LoadCaseFile;
use super::outputs::SensorFile;
use super::read::{Fields, Node, Read, Reader, table, tagged, words};
use super::reduction::ReductionFile;
use super::stations::StationsFile;
use super::times::TimeFile;
use super::values::{At, Count, List, Named, Number, Square, Text, Triple};
use crate::mesh::{InertiaQuadrature, Support};

table! {
    /// A structure, its load cases and the options of its reduction. SI units and radians throughout.
    StructureFile {
        /// What the structure is called and which node carries it.
        structure: Part<Head>,
        /// Numbers by name for use in expressions anywhere in the file; they may refer to each other in any order.
        /// `--set name=expression` overrides them.
        parameters: Option<ParametersFile>,
        /// Materials by name, for sections with a shape.
        materials: Option<Named<Material>>,
        /// Cross-sections by name.
        sections: Part<Named<SectionFile>>,
        /// Named points: ends and corners of members, and places where loads act or results are wanted.
        points: Part<Named<PointFile>>,
        /// Members: the beams.
        members: Part<List<MemberFile>>,
        /// Rigid links between points of members.
        links: Option<List<LinkFile>>,
        /// Rigid masses at named points.
        masses: Option<List<MassFile>>,
        /// Time functions by name, for loads.
        times: Option<Named<TimeFile>>,
        /// Uniform gravity.
        gravity: Option<GravityFile>,
        /// The loaded equilibrium that the structure is modelled about. Without it that is the drawing.
        equilibrium: Option<EquilibriumFile>,
        /// Load cases by name.
        load_cases: Option<Named<LoadCaseFile>>,
        /// Blocks of stations by name, for aerodynamic codes.
        stations: Option<Named<StationsFile>>,
        /// Places where section forces and moments are told, by name.
        internal_loads: Option<Named<InternalLoadsFile>>,
        /// Inertial sensors by name.
        sensors: Option<Named<SensorFile>>,
        /// Structural damping.
        damping: Option<DampingFile>,
        /// How the structure is reduced where the command does not say otherwise.
        reduction: Option<ReductionFile>,
        /// Numerical options.
        options: Option<OptionsFile>,
    }
}

/// A part of the file that may be wrong without keeping the rest from being checked.
#[derive(Clone, Debug)]
pub(crate) struct Part<T>(pub Option<T>);

impl<T: Read> Read for Part<T> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        Some(Self(T::read(node, reader)))
    }

    fn absent(key: &str, _: super::diagnostic::Span, reader: &mut Reader) -> Option<Self> {
        let at = super::diagnostic::Span { start: 0, end: 0 };
        reader.error_help::<()>(at, format!("table `{key}` is missing"), super::TABLES);
        Some(Self(None))
    }
}

impl<T: JsonSchema> JsonSchema for Part<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// `[parameters]` has been resolved before anything else is read.
#[derive(Clone, Debug)]
pub(crate) struct ParametersFile;

impl Read for ParametersFile {
    fn read(_: &Node, _: &mut Reader) -> Option<Self> {
        Some(Self)
    }
}

impl JsonSchema for ParametersFile {
    fn schema_name() -> Cow<'static, str> {
        "Parameters".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Number>();
        json_schema!({ "type": "object", "additionalProperties": number })
    }
}

table! {
    /// Name and reference of the structure.
    Head {
        /// Name of the structure.
        name: Text,
        /// A line or more about it.
        description: Option<Text>,
        /// Named point that carries the body frame A; it must be a node. A's axes are those of this file.
        reference: Text,
        /// Nodes per element where a member does not say otherwise: 2 (linear, default) or 3 (quadratic).
        element_nodes: Option<ElementNodes>,
        /// How it is held: `"free"` (default), or `"clamped"` at the reference.
        support: Option<SupportFile>,
    }
}

words! {
    /// How the structure is held.
    SupportFile {
        /// It flies (default).
        "free" => Free,
        /// Clamped at the reference, which is at rest unless a load case moves it.
        "clamped" => Clamped,
    }
}

impl From<SupportFile> for Support {
    fn from(support: SupportFile) -> Self {
        match support {
            SupportFile::Free => Self::Free,
            SupportFile::Clamped => Self::Clamped,
        }
    }
}

table! {
    /// Numerical options.
    OptionsFile {
        /// Quadrature of the inertia terms.
        inertia_quadrature: Option<Quadrature>,
    }
}

words! {
    /// Quadrature of the inertia terms.
    Quadrature {
        /// One Gauss point more than the stiffness, everywhere (default).
        "consistent" => Consistent,
        /// One Gauss point fewer in the blocks that couple to the rigid motion: gives the digits of Hesse & Palacios (2012).
        "reduced-coupling" => ReducedCoupling,
    }
}

impl From<Quadrature> for InertiaQuadrature {
    fn from(q: Quadrature) -> Self {
        match q {
            Quadrature::Consistent => Self::Consistent,
            Quadrature::ReducedCoupling => Self::ReducedCoupling,
        }
    }
}

/// 2 or 3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElementNodes(pub usize);

impl Read for ElementNodes {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let At { value, span } = Number::read(node, reader)?;
        if value == 2.0 || value == 3.0 {
            return Some(Self(value as usize));
        }
        reader.error(span, format!("elements with {value} nodes, expected 2 (linear) or 3 (quadratic)"))
    }
}

impl JsonSchema for ElementNodes {
    fn schema_name() -> Cow<'static, str> {
        "ElementNodes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "enum": [2, 3] }, { "type": "string" }] })
    }
}

table! {
    /// An isotropic material.
    Material {
        /// Young's modulus, Pa.
        E: Number,
        /// Poisson's ratio, above -1 and below 0.5. G = E / (2 (1 + nu)).
        nu: Number,
        /// Density, kg/m^3.
        rho: Number,
        /// Retardation time of the strains, s. Default: that of `[damping]`.
        retardation_time: Option<Number>,
    }
}

tagged! {
    /// A cross-section. Local x runs along the member, y and z are set by the member's `local_y`. The section's centroid,
    /// shear centre and mass centre lie on the axis unless the matrices say otherwise.
    SectionFile by "shape" {
        "rectangle" => Rectangle,
        "circle" => Circle,
        "tube" => Tube,
        "constants" => Constants,
        "matrix" => Matrix,
    }
}

table! {
    /// Solid rectangle.
    Rectangle {
        /// Name of its material.
        material: Text,
        /// Size along local y, m.
        width_y: Number,
        /// Size along local z, m.
        width_z: Number,
        /// Shear factors k_y, k_z: GA_y = k_y G A. Default 5/6 each.
        shear_factors: Option<[Number; 2]>,
        /// Torsion constant J, m^4: GJ = G J. Default: Saint-Venant's series.
        torsion_constant: Option<Number>,
    }
}

table! {
    /// Solid circle.
    Circle {
        /// Name of its material.
        material: Text,
        /// Diameter, m.
        diameter: Number,
        /// Shear factors k_y, k_z. Default: Cowper (1966), 6 (1 + nu) / (7 + 6 nu).
        shear_factors: Option<[Number; 2]>,
        /// Torsion constant J, m^4. Default: the polar moment of area.
        torsion_constant: Option<Number>,
    }
}

table! {
    /// Circular tube.
    Tube {
        /// Name of its material.
        material: Text,
        /// Outer diameter, m.
        outer_diameter: Number,
        /// Wall thickness, m; less than half the diameter.
        wall_thickness: Number,
        /// Shear factors k_y, k_z. Default: Cowper (1966) for the hollow circle.
        shear_factors: Option<[Number; 2]>,
        /// Torsion constant J, m^4. Default: the polar moment of area.
        torsion_constant: Option<Number>,
    }
}

table! {
    /// Section given by its engineering constants, uncoupled.
    Constants {
        /// Axial stiffness, N.
        EA: Number,
        /// Shear stiffness along local y, N.
        GAy: Number,
        /// Shear stiffness along local z, N.
        GAz: Number,
        /// Torsional stiffness, N m^2.
        GJ: Number,
        /// Bending stiffness about local y, N m^2.
        EIy: Number,
        /// Bending stiffness about local z, N m^2.
        EIz: Number,
        /// Mass per length, kg/m.
        rhoA: Number,
        /// Rotary inertia per length about local x, y, z, kg m.
        rhoJ: Triple,
        /// Retardation time of the strains, s. Default: that of `[damping]`.
        retardation_time: Option<Number>,
    }
}

table! {
    /// Section given by full matrices, as composite section programs give them.
    Matrix {
        /// 6x6 stiffness over (force x y z, moment x y z) against (gamma, kappa), symmetric positive definite; N, N m, N m^2.
        stiffness: Square<6>,
        /// 6x6 mass over (velocity x y z, angular velocity x y z), symmetric positive definite; kg/m, kg, kg m.
        mass: Square<6>,
        /// Retardation time of the strains, s. Default: that of `[damping]`.
        retardation_time: Option<Number>,
    }
}

/// A named point.
#[derive(Clone, Debug)]
pub(crate) enum PointFile {
    Position(Triple),
    Linked(LinkedPoint),
    OnMember(MemberPoint),
}

table! {
    /// A point rigidly linked to another.
    LinkedPoint {
        /// Named point that carries it.
        linked_to: Text,
        /// From that point to this, axes of the drawing, m.
        offset: Triple,
    }
}

table! {
    /// A point on the axis of a member, at one of its nodes.
    MemberPoint {
        /// Name of the member.
        member: Text,
        /// Fraction of the member's length from its start, 0 to 1.
        fraction: Number,
    }
}

impl Read for PointFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        if let DeValue::Array(_) = node.get_ref() {
            return Triple::read(node, reader).map(Self::Position);
        }
        if !node.get_ref().is_table() {
            let message = "a point is given as [x, y, z], { linked_to, offset } or { member, fraction }";
            return reader.error(node.span().into(), message);
        }
        let fields = Fields::of(node, reader)?;
        if fields.has("member") || fields.has("fraction") {
            MemberPoint::read_fields(fields, reader).map(Self::OnMember)
        } else {
            LinkedPoint::read_fields(fields, reader).map(Self::Linked)
        }
    }
}

impl JsonSchema for PointFile {
    fn schema_name() -> Cow<'static, str> {
        "Point".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let position = generator.subschema_for::<Triple>();
        let linked = generator.subschema_for::<LinkedPoint>();
        let member = generator.subschema_for::<MemberPoint>();
        json_schema!({
            "description": "A named point: [x, y, z] in m, { linked_to, offset } or { member, fraction }.",
            "anyOf": [position, linked, member],
        })
    }
}

table! {
    /// A beam along a polyline (`path`) or a circular arc (`arc`) between named points. Members meet where they name the
    /// same point.
    MemberFile {
        /// Name of the member.
        name: Text,
        /// Names of the points it goes through, straight from one to the next.
        path: Option<List<Text>>,
        /// A circular arc.
        arc: Option<ArcFile>,
        /// Name of its section; or tapered: the names at [start, end], or [[fraction, name], ...] of the length, linear between.
        section: CourseFile<Text>,
        /// Number of elements, shared out by length on a polyline; or a list with the number for each straight piece.
        elements: ElementsFile,
        /// Nodes per element, 2 or 3; default that of the structure.
        element_nodes: Option<ElementNodes>,
        /// Vector that fixes the section: local z = x cross local_y (normalised), local y = z cross x.
        local_y: Triple,
        /// Turn of the section about local x, rad: one number; or [start, end], or [[fraction, turn], ...] of the length, linear
        /// between. Default 0.
        twist: Option<CourseFile<Number>>,
    }
}

table! {
    /// A circular arc between named points: through a third place, or the shorter way about a centre.
    ArcFile {
        /// Name of the point where it starts.
        from: Text,
        /// Name of the point where it ends.
        to: Text,
        /// Coordinates of a place on the arc between them, m.
        through: Option<Triple>,
        /// Coordinates of the centre, m; the arc turns by less than half a circle.
        center: Option<Triple>,
    }
}

/// Element counts of a member.
#[derive(Clone, Debug)]
pub(crate) enum ElementsFile {
    Total(Count),
    Each(List<Count>),
}

impl Read for ElementsFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        match node.get_ref() {
            DeValue::Array(_) => List::read(node, reader).map(Self::Each),
            _ => Count::read(node, reader).map(Self::Total),
        }
    }
}

impl JsonSchema for ElementsFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Elements".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<Count>();
        let list = generator.subschema_for::<List<Count>>();
        json_schema!({ "anyOf": [one, list] })
    }
}

table! {
    /// A massless rigid body that joins members: its points keep their distances and turn together.
    LinkFile {
        /// Name, for people.
        name: Option<Text>,
        /// Two or more named points that members go through.
        points: List<Text>,
    }
}

table! {
    /// A rigid mass at a named point.
    MassFile {
        /// Name, for people.
        name: Option<Text>,
        /// Named point it is fixed to.
        point: Text,
        /// Mass, kg.
        mass: Number,
        /// From the point to its centre of mass, axes of the drawing, m. Default zero.
        offset: Option<Triple>,
        /// Inertia about its centre of mass, axes of the drawing, kg m^2: [Jxx, Jyy, Jzz] or a symmetric 3x3 matrix. Default zero.
        inertia: Option<InertiaFile>,
    }
}

/// Inertia of a rigid mass about its centre of mass.
#[derive(Clone, Debug)]
pub(crate) struct InertiaFile(pub Square<3>);

impl Read for InertiaFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let matrix =
            node.get_ref().as_array().is_some_and(|list| list.iter().any(|row| row.get_ref().is_array()));
        if matrix {
            return Square::read(node, reader).map(Self);
        }
        let Triple { value, span } = Triple::read(node, reader)?;
        let value = Box::new(nalgebra::Matrix3::from_diagonal(&value));
        Some(Self(Square { value, span, entries: vec![span; 9] }))
    }
}

impl JsonSchema for InertiaFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Inertia".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let diagonal = generator.subschema_for::<Triple>();
        let full = generator.subschema_for::<Square<3>>();
        json_schema!({ "anyOf": [diagonal, full] })
    }
}
