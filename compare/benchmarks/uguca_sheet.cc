// A slipfront benchmark with UGUCA 0.9: two half-spaces, slot x < 0, contact x > 0.
// Parameters are read from the file that is given, kernels from the folder that it names.
// The edge of the contact lies half a cell behind the last node of the slot.
#include "bimat_interface.hh"
#include "linear_coulomb_friction_law.hh"
#include "material.hh"
#include "static_communicator_mpi.hh"
#include "uca_parameter_reader.hh"
#include "unimat_shear_interface.hh"

#include <cmath>
#include <memory>
#include <string>

using namespace uguca;

// Coulomb's law, but nothing on the slot, whose faces may not even touch; and a viscous film.
class ContactLaw : public LinearCoulombFrictionLaw {
public:
  ContactLaw(Mesh & mesh, double friction, int slot, double viscosity, double impedance)
      : LinearCoulombFrictionLaw(mesh, friction, friction, 1.), slot(slot), viscosity(viscosity),
        radiated(impedance / 2) {}

  void computeCohesiveForces(std::vector<NodalField *> & force, bool predicting = false) {
    LinearCoulombFrictionLaw::computeCohesiveForces(force, predicting);
    int nodes = force[0]->getNbNodes();
    if (viscosity > 0) {
      NodalField dry(nodes);
      for (int n = 0; n < nodes; ++n)
        dry(n) = (*force[0])(n);
      interface->maintainShearGapForce(force); // what would hold
      for (int n = 0; n < nodes; ++n) {
        double rate = ((*force[0])(n)-dry(n)) / (radiated + viscosity);
        (*force[0])(n) = dry(n) + viscosity * rate;
      }
    }
    for (NodalField * part : force)
      for (int n = 0; n < slot; ++n)
        (*part)(n) = 0.;
  }

private:
  int slot;
  double viscosity, radiated;
};

int main(int, char * argv[]) {
  StaticCommunicatorMPI::getInstance();
  ParameterReader in;
  in.readInputFile(argv[1]);
  auto number = [&in](const char * name) { return in.get<double>(name); };
  int axis = in.get<int>("axis"), cells = in.get<int>("cells"), slot = in.get<int>("slot_nodes");
  int steps_per_cell = in.get<int>("steps_per_cell");
  double length = number("length"), nu = number("poisson_ratio"), friction = number("friction");

  int nodes = std::lround(length * cells);
  bool antiplane = axis == 2, pressed = in.get<int>("pressed");
  std::unique_ptr<Mesh> mesh(antiplane ? new Mesh(length, nodes, length, 1) : new Mesh(length, nodes));
  double lower_nu = number("lower_poisson_ratio");
  Material upper(2 * (1 + nu), nu, 1.);
  Material lower(2 * number("lower_shear_modulus") * (1 + lower_nu), lower_nu, number("lower_density"));
  upper.readPrecomputedKernels(in.get<std::string>("kernels"));
  lower.readPrecomputedKernels(in.get<std::string>("kernels"));

  ContactLaw law(*mesh, friction, slot, number("viscosity"), 1.);
  std::unique_ptr<Interface> contact;
  if (pressed)
    contact.reset(new BimatInterface(*mesh, upper, lower, law));
  else
    contact.reset(new UnimatShearInterface(*mesh, upper, law));

  double step = 1. / cells / steps_per_cell;
  contact->setTimeStep(step);
  NodalField * shear = antiplane ? contact->getLoad(2) : contact->getShearLoad();
  NodalField * normal = contact->getNormalLoad();
  for (int n = 0; n < nodes; ++n) {
    (*shear)(n) = number(n < slot ? "slot_shear" : "contact_shear");
    (*normal)(n) = -number(n < slot ? "slot_pressure" : "contact_pressure");
  }
  contact->init();
  contact->initDump(in.get<std::string>("name"), ".");
  contact->registerDumpFields(in.get<std::string>("dump_fields"));
  contact->dump(0, 0);
  int steps = cells * steps_per_cell;
  for (int s = 1; s <= steps; ++s) {
    if ((s + 0.5) * step > number("shear_until"))
      for (int n = 0; n < slot; ++n)
        (*shear)(n) = number("contact_shear");
    contact->advanceTimeStep();
    contact->dump(s, s * step);
  }
  return 0;
}
