// A hand of two fingers (btMultiBody) grips a cloth that hangs over a board, and lifts it, in the deformable world.
// Returns 0 if the cloth comes along and nothing passes anything.
#include <quickcullide/bullet.h>
#include <quickcullide/bullet_deformable.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>

int main()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase; // instead of btDbvtBroadphase
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    solver.setDeformableSolver(&deformableSolver);
    qcDeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);

    // A bar that slides up, and two fingers that slide along it towards each other.
    const btVector3 none(0, 0, 0), finger(btScalar(0.02), btScalar(0.1), btScalar(0.05)), inertia(1, 1, 1);
    const btQuaternion upright = btQuaternion::getIdentity();
    btMultiBody hand(3, 0, inertia, true, false); // three links on a fixed base
    hand.setBasePos(btVector3(0, 1, 0));
    hand.setupPrismatic(0, 1, inertia / 100, -1, upright, btVector3(0, 1, 0), none, none, true);
    for (int i = 1; i < 3; i++)
    {
        const btScalar side = i == 1 ? btScalar(-1) : btScalar(1);
        hand.setupPrismatic(i, btScalar(0.3), inertia / 1000, 0, upright, btVector3(-side, 0, 0),
                            btVector3(btScalar(0.3) * side, btScalar(-1.15), 0), none, true);
    }
    hand.finalizeMultiDof();
    world.addMultiBody(&hand);
    btBoxShape shapes[] = {btBoxShape(btVector3(btScalar(0.3), btScalar(0.02), btScalar(0.02))), btBoxShape(finger),
                           btBoxShape(finger)};
    btMultiBodyLinkCollider links[] = {{&hand, 0}, {&hand, 1}, {&hand, 2}};
    btMultiBodyJointMotor motors[] = {{&hand, 0, 0, 50}, {&hand, 1, 0, 1}, {&hand, 2, 0, 1}};
    for (int i = 0; i < 3; i++)
    {
        links[i].setCollisionShape(&shapes[i]);
        links[i].setFriction(1);
        hand.getLink(i).m_collider = &links[i];
        world.addCollisionObject(&links[i], btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
        motors[i].finalizeMultiDof();
        world.addMultiBodyConstraint(&motors[i]);
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    hand.forwardKinematics(rotations, origins);
    hand.updateCollisionObjectWorldTransforms(rotations, origins);

    btBoxShape boardShape(btVector3(btScalar(0.02), btScalar(0.3), btScalar(0.3)));
    btRigidBody board(0, nullptr, &boardShape);
    board.setWorldTransform(btTransform(upright, btVector3(0, btScalar(-0.35), 0)));
    world.addRigidBody(&board);
    btDeformableMassSpringForce springs(30, btScalar(0.2), true);
    btDeformableGravityForce gravity(world.getGravity());
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 0, -1) / 2, btVector3(1, 0, -1) / 2,
                                       btVector3(-1, 0, 1) / 2, btVector3(1, 0, 1) / 2, 15, 15, 0, true);
    cloth->setTotalMass(btScalar(0.5));
    world.addSoftBody(cloth);
    world.addForce(cloth, &springs);
    world.addForce(cloth, &gravity);
    qcSoftBodySettings settings;
    settings.friction = 1;
    world.setSettings(cloth, settings);

    int status = 0;
    for (int i = 0; i < 600; i++)
    {
        for (int k = 1; k < 3; k++)
            motors[k].setVelocityTarget(i > 120 ? btScalar(0.3) : btScalar(0));
        motors[0].setVelocityTarget(i > 360 ? btScalar(0.4) : btScalar(0));
        world.stepSimulation(btScalar(1.0 / 120), 0);
        status = world.getStatistics().remaining == 0 ? status : 1; // pairs that penetrate
    }
    btScalar lowest = 1;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        lowest = std::min(lowest, cloth->m_nodes[i].m_x.y());

    for (btMultiBodyJointMotor& motor : motors)
        world.removeMultiBodyConstraint(&motor);
    for (btMultiBodyLinkCollider& link : links)
        world.removeCollisionObject(&link);
    world.removeMultiBody(&hand);
    world.removeSoftBody(cloth);
    delete cloth;
    world.removeRigidBody(&board);
    return lowest > btScalar(-0.3) ? status : 1; // it hung down to -0.5
}
