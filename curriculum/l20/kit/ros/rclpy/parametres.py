"""La moitié de `Node` qui tient ses paramètres. (Dans ROS 2, elle est dans `rclpy/node.py`.)"""

import math
import warnings

from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent, ParameterType, ParameterValue, SetParametersResult

from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import Parameter, parameter_value_to_python

MAUVAIS_TYPE = "Wrong parameter type"
SANS_REPONSE = (
    "'NoneType' object has no attribute 'successful' (la fonction donnée à add_on_set_parameters_callback doit "
    "renvoyer un SetParametersResult)"
)


def _refus(raison):
    return SetParametersResult(successful=False, reason=raison)


class Parametres:
    """Déclarer, lire, changer : du dedans par ces méthodes, du dehors par `ros2 param set`."""

    def _ros_preparer_parametres(self, surcharges, sans_declaration):
        self._ros_parametres, self._ros_descripteurs = {}, {}
        self._ros_surcharges, self._ros_sans_declaration = surcharges, sans_declaration
        self._ros_avant, self._ros_pendant, self._ros_apres = [], [], []

    def declare_parameter(self, name, value=None, descriptor=None, ignore_override=False):
        """Crée un paramètre, avec sa valeur par défaut (ou `Parameter.Type.DOUBLE` : un type sans valeur)."""
        seul = value is None and descriptor is None
        return self.declare_parameters("", [(name,) if seul else (name, value, descriptor)], ignore_override)[0]

    def declare_parameters(self, namespace, parameters, ignore_override=False):
        """Plusieurs à la fois : une liste de (nom, valeur) ou de (nom, valeur, description)."""
        nouveaux = [self._ros_lire_declaration(namespace, declare, ignore_override) for declare in parameters]
        deja = [parametre.name for parametre, _ in nouveaux if parametre.name in self._ros_parametres]
        if deja:
            raise ParameterAlreadyDeclaredException(deja)
        for parametre, descripteur in nouveaux:
            resultat = self._ros_changer([parametre], {parametre.name: descripteur})
            if not resultat.successful:
                if resultat.reason.startswith(MAUVAIS_TYPE):
                    raise InvalidParameterTypeException(parametre, Parameter.Type(descripteur.type).name)
                raise InvalidParameterValueException(parametre.name, parametre.value, resultat.reason)
        return [self._ros_parametres[parametre.name] for parametre, _ in nouveaux]

    def _ros_lire_declaration(self, namespace, declare, ignore_override):
        if not 1 <= len(declare) <= 3:
            raise TypeError(f"Invalid parameter tuple length: {declare}; expecting length between 1 and 3")
        nom, valeur, descripteur = (*declare, None, None)[:3]
        if not isinstance(nom, str):
            raise TypeError(f"First element {nom} in parameters list is not a str.")
        if not nom:
            raise InvalidParameterException(nom)
        nom = f"{namespace}.{nom}" if namespace else nom
        descripteur = ParameterDescriptor() if descripteur is None else descripteur
        if not isinstance(descripteur, ParameterDescriptor):
            raise TypeError(f"Third element {descripteur} in parameters list is not a ParameterDescriptor.")
        if len(declare) == 1:
            warnings.warn(f"when declaring parameter '{nom}', only its name is provided: deprecated", stacklevel=4)
            descripteur.dynamic_typing = True
        if isinstance(valeur, Parameter.Type):
            if valeur is Parameter.Type.NOT_SET:
                raise ValueError(f"Cannot declare parameter {{{nom}}} as statically typed of type NOT_SET")
            descripteur.type, valeur = valeur.value, None
        else:
            valeur = parameter_value_to_python(valeur) if isinstance(valeur, ParameterValue) else valeur
            if not descripteur.dynamic_typing:
                descripteur.type = Parameter.Type.from_parameter_value(valeur).value
                if descripteur.type == ParameterType.PARAMETER_NOT_SET:
                    raise ValueError("Cannot declare a statically typed parameter with default value of type NOT_SET")
        if not ignore_override and nom in self._ros_surcharges:
            valeur = self._ros_surcharges[nom]
        return Parameter(nom, value=valeur), descripteur

    def undeclare_parameter(self, name):
        if self.describe_parameter(name).read_only:
            raise ParameterImmutableException(name)
        del self._ros_parametres[name], self._ros_descripteurs[name]

    def has_parameter(self, name):
        return name in self._ros_parametres

    def get_parameter(self, name):
        """Le paramètre ; sa valeur du moment est `.value`."""
        if name in self._ros_parametres:
            parametre = self._ros_parametres[name]
            if parametre.type_ is Parameter.Type.NOT_SET and not self._ros_descripteurs[name].dynamic_typing:
                raise ParameterUninitializedException(name)
            return parametre
        if self._ros_sans_declaration:
            return Parameter(name, Parameter.Type.NOT_SET, None)
        raise ParameterNotDeclaredException(name)

    def get_parameters(self, names):
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name, alternative_value=None):
        parametre = self._ros_parametres.get(name)
        if parametre is not None and parametre.type_ is not Parameter.Type.NOT_SET:
            return parametre
        return Parameter(name, Parameter.Type.NOT_SET) if alternative_value is None else alternative_value

    def get_parameter_type(self, name):
        return self.get_parameter(name).type_

    def get_parameters_by_prefix(self, prefix):
        debut = f"{prefix}." if prefix else ""
        return {nom[len(debut) :]: p for nom, p in self._ros_parametres.items() if nom.startswith(debut)}

    def describe_parameter(self, name):
        if name not in self._ros_descripteurs:
            if self._ros_sans_declaration:
                return ParameterDescriptor()
            raise ParameterNotDeclaredException(name)
        return self._ros_descripteurs[name]

    def set_parameters(self, parameter_list):
        """Change des paramètres, l'un après l'autre ; dit pour chacun si c'est fait, et sinon pourquoi."""
        return [self.set_parameters_atomically([parametre]) for parametre in parameter_list]

    def set_parameters_atomically(self, parameter_list):
        """Tous, ou aucun."""
        for fonction in self._ros_avant:
            parameter_list = fonction(parameter_list)
        if not parameter_list:
            return _refus("parameter list cannot be empty")
        inconnus = [parametre.name for parametre in parameter_list if parametre.name not in self._ros_parametres]
        if inconnus and not self._ros_sans_declaration:
            raise ParameterNotDeclaredException(inconnus)
        return self._ros_changer(parameter_list)

    def add_pre_set_parameters_callback(self, callback):
        """`callback(liste)` renvoie la liste à appliquer."""
        self._ros_avant.insert(0, callback)

    def add_on_set_parameters_callback(self, callback):
        """`callback(liste)` renvoie un `SetParametersResult` : oui, ou non et pourquoi. Rien n'est encore changé."""
        self._ros_pendant.insert(0, callback)

    def add_post_set_parameters_callback(self, callback):
        """`callback(liste)` est appelé quand le changement est fait."""
        self._ros_apres.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback):
        self._ros_avant.remove(callback)

    def remove_on_set_parameters_callback(self, callback):
        self._ros_pendant.remove(callback)

    def remove_post_set_parameters_callback(self, callback):
        self._ros_apres.remove(callback)

    def _ros_changer(self, parametres, descripteurs=None):
        for parametre in parametres:
            resultat = self._ros_verifier(parametre, descripteurs)
            if not resultat.successful:
                return resultat
        for fonction in self._ros_pendant:
            resultat = fonction(parametres)
            if resultat is None:
                raise AttributeError(SANS_REPONSE)
            if not resultat.successful:
                return resultat
        evenement = ParameterEvent(node=self.get_fully_qualified_name(), stamp=self.get_clock().now().to_msg())
        for parametre in parametres:
            nouveau = parametre.name not in self._ros_parametres
            (evenement.new_parameters if nouveau else evenement.changed_parameters).append(parametre.to_parameter_msg())
            self._ros_parametres[parametre.name] = parametre
            if descripteurs is not None:
                self._ros_descripteurs[parametre.name] = descripteurs[parametre.name]
            self._ros_descripteurs.setdefault(parametre.name, ParameterDescriptor(dynamic_typing=True))
        self._ros_annonce_parametres.publish(evenement)
        for fonction in self._ros_apres:
            fonction(parametres)
        return SetParametersResult(successful=True)

    def _ros_verifier(self, parametre, descripteurs):
        """Le type et les bornes déclarés acceptent-ils cette valeur ?"""
        declare = (descripteurs or self._ros_descripteurs).get(parametre.name)
        if declare is None:
            return SetParametersResult(successful=True)
        if descripteurs is None and declare.read_only:
            return _refus(f"Trying to set a read-only parameter: {parametre.name}.")
        if declare.dynamic_typing:
            declare.type = parametre.type_.value
        elif parametre.type_ is Parameter.Type.NOT_SET:
            if descripteurs is None:
                return _refus("Static parameter cannot be undeclared")
        elif parametre.type_.value != declare.type:
            attendu = Parameter.Type(declare.type)
            return _refus(f"{MAUVAIS_TYPE}, expected '{attendu}' got '{parametre.type_}'")
        bornes = {Parameter.Type.INTEGER: declare.integer_range, Parameter.Type.DOUBLE: declare.floating_point_range}
        for borne in bornes.get(parametre.type_, ())[:1]:
            bas, haut = sorted((borne.from_value, borne.to_value))
            au_bord = any(math.isclose(parametre.value, bord, rel_tol=1e-6) for bord in (bas, haut))
            if not au_bord and not bas < parametre.value < haut:
                raison = f"Parameter {parametre.name} out of range Min: {bas}, Max: {haut}, value: {parametre.value}"
                return _refus(raison)
        return SetParametersResult(successful=True)
