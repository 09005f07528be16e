"""Sign-in by a CAS server (CAS Protocol 3.0): an ENT of French schools, or a university."""
