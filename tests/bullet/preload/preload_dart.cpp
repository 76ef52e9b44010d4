// DART with its Bullet plugin, which creates its own btDbvtBroadphase: boxes and balls fall on a floor, and every
// contact is printed. Rounded, and sorted in each step: DART's solver sums contacts in the order of Bullet's pairs.
#include <dart/collision/bullet/BulletCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace
{
void AddBody(const dart::simulation::WorldPtr& world, int number, const Eigen::Vector3d& place)
{
    auto skeleton = dart::dynamics::Skeleton::create("body " + std::to_string(number));
    auto pair = skeleton->createJointAndBodyNodePair<dart::dynamics::FreeJoint>();
    dart::dynamics::ShapePtr shape;
    if (number % 2 == 0)
        shape = std::make_shared<dart::dynamics::BoxShape>(Eigen::Vector3d(0.6, 0.4, 0.5));
    else
        shape = std::make_shared<dart::dynamics::SphereShape>(0.3);
    pair.second->createShapeNodeWith<dart::dynamics::CollisionAspect, dart::dynamics::DynamicsAspect>(shape);
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    at.translation() = place;
    pair.first->setTransformFromParentBodyNode(at);
    world->addSkeleton(skeleton);
}

void AddFloor(const dart::simulation::WorldPtr& world)
{
    auto skeleton = dart::dynamics::Skeleton::create("floor");
    auto pair = skeleton->createJointAndBodyNodePair<dart::dynamics::WeldJoint>();
    pair.second->createShapeNodeWith<dart::dynamics::CollisionAspect, dart::dynamics::DynamicsAspect>(
        std::make_shared<dart::dynamics::BoxShape>(Eigen::Vector3d(20, 20, 1)));
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    at.translation().z() = -0.5;
    pair.first->setTransformFromParentBodyNode(at);
    world->addSkeleton(skeleton);
}
} // namespace

int main()
{
    auto world = dart::simulation::World::create();
    world->getConstraintSolver()->setCollisionDetector(dart::collision::BulletCollisionDetector::create());
    AddFloor(world);
    for (int i = 0; i < 8; i++)
        AddBody(world, i, Eigen::Vector3d(0.25 * (i % 3), 0.2 * (i % 2), 0.5 + 0.7 * i));
    for (int step = 0; step < 1500; step++)
    {
        world->step();
        const dart::collision::CollisionResult& result = world->getLastCollisionResult();
        std::vector<std::string> lines;
        for (size_t i = 0; i < result.getNumContacts(); i++)
        {
            const dart::collision::Contact& contact = result.getContact(i);
            char line[200];
            std::snprintf(line, sizeof line, "%d: %.5f %.5f %.5f, depth %.5f\n", step, contact.point.x(),
                          contact.point.y(), contact.point.z(), contact.penetrationDepth);
            lines.push_back(line);
        }
        std::sort(lines.begin(), lines.end());
        for (const std::string& line : lines)
            std::fputs(line.c_str(), stdout);
    }
    for (size_t i = 0; i < world->getNumSkeletons(); i++)
        std::printf("%s rests at height %.5f\n", world->getSkeleton(i)->getName().c_str(),
                    world->getSkeleton(i)->getBodyNode(0)->getTransform().translation().z());
    return 0;
}
