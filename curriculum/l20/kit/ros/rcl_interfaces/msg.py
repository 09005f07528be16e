"""Ce que les paramètres échangent : descriptions, valeurs, résultats d'un changement."""

from builtin_interfaces.msg import Time
from champs import BOOLEEN, DOUBLE, INT64, TEXTE, UINT8, UINT64, Liste, Message, Tableau


class ParameterType(Message):
    PARAMETER_NOT_SET = 0
    PARAMETER_BOOL = 1
    PARAMETER_INTEGER = 2
    PARAMETER_DOUBLE = 3
    PARAMETER_STRING = 4
    PARAMETER_BYTE_ARRAY = 5
    PARAMETER_BOOL_ARRAY = 6
    PARAMETER_INTEGER_ARRAY = 7
    PARAMETER_DOUBLE_ARRAY = 8
    PARAMETER_STRING_ARRAY = 9


class ParameterValue(Message):
    champs = {
        "type": UINT8,
        "bool_value": BOOLEEN,
        "integer_value": INT64,
        "double_value": DOUBLE,
        "string_value": TEXTE,
        "byte_array_value": Liste(bytes, "octet"),
        "bool_array_value": Liste(bool, "boolean"),
        "integer_array_value": Tableau("q", "int64", int),
        "double_array_value": Tableau("d", "double"),
        "string_array_value": Liste(str, "string"),
    }


class Parameter(Message):
    champs = {"name": TEXTE, "value": ParameterValue}


class FloatingPointRange(Message):
    champs = {"from_value": DOUBLE, "to_value": DOUBLE, "step": DOUBLE}


class IntegerRange(Message):
    champs = {"from_value": INT64, "to_value": INT64, "step": UINT64}


class ParameterDescriptor(Message):
    champs = {
        "name": TEXTE,
        "type": UINT8,
        "description": TEXTE,
        "additional_constraints": TEXTE,
        "read_only": BOOLEEN,
        "dynamic_typing": BOOLEEN,
        "floating_point_range": Liste(FloatingPointRange),
        "integer_range": Liste(IntegerRange),
    }


class SetParametersResult(Message):
    champs = {"successful": BOOLEEN, "reason": TEXTE}


class ParameterEvent(Message):
    champs = {
        "stamp": Time,
        "node": TEXTE,
        "new_parameters": Liste(Parameter),
        "changed_parameters": Liste(Parameter),
        "deleted_parameters": Liste(Parameter),
    }
