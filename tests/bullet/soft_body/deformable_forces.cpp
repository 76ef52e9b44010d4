// Bullet's forces of deformable bodies are inline functions, in which simulations spend much of their time. Here they
// are compiled as for a release; the linker takes the first of equal inline functions, and this file comes first.
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>

/// Called by nothing: the compiler emits the classes for it.
void qcNewDeformableForces(btDeformableLagrangianForce* forces[3])
{
    forces[0] = new btDeformableLinearElasticityForce;
    forces[1] = new btDeformableMassSpringForce;
    forces[2] = new btDeformableNeoHookeanForce;
}
