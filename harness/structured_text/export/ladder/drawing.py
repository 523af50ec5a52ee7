"""The XML of a diagram in the format PLCopen TC6, as Beremiz, OpenPLC Editor and CODESYS read it.

Source: PLCopen, TC6 XML Formats for IEC 61131-3, version 2.01, chapters 5 and 6.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree as ET

from structured_text.export.ladder.layout import Box, Layout, layout_of
from structured_text.projects.diagrams.networks import model as m

__all__ = ["write_diagram"]


def write_diagram(
    parent: ET.Element, diagram: m.Diagram, expression: Callable[[str], str] = str
) -> None:
    """Add a diagram to the `<body>` of a POU, rung after rung.

    `expression` returns an expression in the form of the file.
    """
    body = ET.SubElement(parent, diagram.language)
    writer = _Writer(diagram, layout_of(diagram), expression)
    for network in diagram.networks:
        writer.network(body, network)


class _Writer:
    def __init__(
        self, diagram: m.Diagram, layout: Layout, expression: Callable[[str], str]
    ) -> None:
        self._diagram, self._layout, self._expression = diagram, layout, expression
        self._known = {element.id: element for element in diagram.elements}
        self._comments = len(diagram.elements)

    def network(self, body: ET.Element, network: m.Network) -> None:
        if network.comment:
            self._comments += 1
            box = self._layout.comments[network.number]
            comment = self._object(body, "comment", str(self._comments), box)
            content = ET.SubElement(comment, "content")
            ET.SubElement(content, "xhtml:p").text = network.comment
        for element in self._diagram.elements:
            if element.network == network.number:
                self._element(body, element)

    def _object(self, body: ET.Element, name: str, number: str, box: Box) -> ET.Element:
        size = {"width": str(box.width), "height": str(box.height)}
        found = ET.SubElement(body, name, {"localId": number, **size})
        _point(found, "position", box.x, box.y)
        return found

    def _element(self, body: ET.Element, element: m.Element) -> None:
        box = self._layout.elements[element.id]
        name = type(element).__name__
        if isinstance(element, m.Rail):
            name = "leftPowerRail" if element.left else "rightPowerRail"
        xml = self._object(body, name[0].lower() + name[1:], element.id, box)
        if element.order:
            xml.set("executionOrderId", str(element.order))
        if isinstance(element, m.Rail):
            self._rail(xml, element, box)
        elif isinstance(element, m.Contact | m.Coil):
            self._contact(xml, element, box)
        elif isinstance(element, m.Block):
            self._block(xml, element, box)
        elif isinstance(element, m.InVariable):
            xml.set("negated", "false")
            _point(
                ET.SubElement(xml, "connectionPointOut"), "relPosition", box.width, box.outputs[0]
            )
            ET.SubElement(xml, "expression").text = self._expression(element.expression)
        elif isinstance(element, m.OutVariable):
            xml.set("negated", "false")
            self._input(xml, element, element.input, 0)
            ET.SubElement(xml, "expression").text = element.expression

    def _rail(self, xml: ET.Element, rail: m.Rail, box: Box) -> None:
        if rail.left:
            for height in box.outputs:
                point = ET.SubElement(xml, "connectionPointOut", formalParameter="")
                _point(point, "relPosition", box.width, height)
            return
        coils = [
            one
            for one in self._diagram.elements
            if isinstance(one, m.Coil) and one.network == rail.network
        ]
        for number, coil in enumerate(coils):
            self._input(xml, rail, m.Input(connections=(m.Connection(coil.id),)), number)

    def _contact(self, xml: ET.Element, element: m.Contact | m.Coil, box: Box) -> None:
        xml.set("negated", "true" if element.negated else "false")
        if isinstance(element, m.Coil):
            xml.set("storage", element.storage or "none")
        self._input(xml, element, element.input, 0)
        _point(ET.SubElement(xml, "connectionPointOut"), "relPosition", box.width, box.outputs[0])
        ET.SubElement(xml, "variable").text = element.variable

    def _block(self, xml: ET.Element, block: m.Block, box: Box) -> None:
        xml.set("typeName", block.type)
        if block.instance:
            xml.set("instanceName", block.instance)
        inputs = ET.SubElement(xml, "inputVariables")
        for number, given in enumerate(block.inputs):
            pin = ET.SubElement(inputs, "variable", formalParameter=given.name)
            self._input(pin, block, given, number)
        ET.SubElement(xml, "inOutVariables")
        outputs = ET.SubElement(xml, "outputVariables")
        for number, output in enumerate(block.outputs):
            pin = ET.SubElement(outputs, "variable", formalParameter=output.name)
            point = ET.SubElement(pin, "connectionPointOut")
            _point(point, "relPosition", box.width, box.outputs[number])

    # --- lines ---

    def _input(self, xml: ET.Element, element: m.Element, given: m.Input, number: int) -> None:
        """Write an input with its lines; each line goes from the input back to its source."""
        box = self._layout.elements[element.id]
        point = ET.SubElement(xml, "connectionPointIn")
        _point(point, "relPosition", 0, box.inputs[number])
        x, y = box.x, box.y + box.inputs[number]
        for line in given.connections:
            attributes = {"refLocalId": line.source}
            if line.pin:
                attributes["formalParameter"] = line.pin
            connection = ET.SubElement(point, "connection", attributes)
            source_x, source_y = self._output(line, y)
            bend = x - 10 - 5 * (number % 6)
            path = [(x, y), (source_x, source_y)]
            if y != source_y:
                path[1:1] = [(bend, y), (bend, source_y)]
            for place in path:
                _point(connection, "position", *place)

    def _output(self, line: m.Connection, y: int) -> tuple[int, int]:
        """Return where a line begins; at a rail in the row of its end, if there is a pin."""
        source, box = self._known[line.source], self._layout.elements[line.source]
        heights = [box.y + height for height in box.outputs]
        number = 0
        if isinstance(source, m.Block):
            number = [pin.name for pin in source.outputs].index(line.pin)
        elif isinstance(source, m.Rail) and y in heights:
            number = heights.index(y)
        return box.x + box.width, heights[number]


def _point(parent: ET.Element, name: str, x: int, y: int) -> None:
    ET.SubElement(parent, name, x=str(x), y=str(y))
