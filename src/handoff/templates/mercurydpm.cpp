{{heading}}
// Put it in a folder of Drivers/ and build it as any driver there.
#include <cstdlib>
#include <iostream>

#include "Mercury3D.h"
#include "Species/LinearViscoelasticSpecies.h"
#include "Walls/InfiniteWall.h"

class Drop : public Mercury3D
{
public:
    double speed = {{speed}}; // m/s

    void setupInitialConditions() override
    {
        SphericalParticle sphere(speciesHandler.getObject(0));
        sphere.setRadius({{radius}}); // m
        sphere.setPosition(Vec3D(0.0, 0.0, {{start}}));
        sphere.setVelocity(Vec3D(0.0, 0.0, -speed));
        particleHandler.copyAndAddObject(sphere);

        InfiniteWall plate;
        plate.setSpecies(speciesHandler.getObject(1));
        plate.set(Vec3D(0.0, 0.0, -1.0), Vec3D(0.0, 0.0, 0.0));
        wallHandler.copyAndAddObject(plate);
    }
};

int main(int argc, char* argv[])
{
    Drop drop;
    if (argc > 1) drop.speed = std::atof(argv[1]);
    const double mass = {{mass}}; // kg
    const double stiffness = {{stiffness}}; // N/m, for this test's time step: e does not depend on it

    auto spheres = drop.speciesHandler.copyAndAddObject(LinearViscoelasticSpecies());
    auto plate = drop.speciesHandler.copyAndAddObject(LinearViscoelasticSpecies());
    auto both = drop.speciesHandler.getMixedObject(spheres, plate);
    spheres->setDensity({{density}}); // kg/m3
    plate->setDensity({{density}});
    // the last argument is twice the effective mass: m for two equal spheres, 2 m for a sphere on a plate
    spheres->setStiffnessAndRestitutionCoefficient(stiffness, {{pair}}, mass);
    both->setStiffnessAndRestitutionCoefficient(stiffness, {{e}}, 2.0 * mass);

    drop.setName("drop_mercurydpm");
    drop.setSystemDimensions(3);
    drop.setParticleDimensions(3);
    drop.setGravity(Vec3D(0.0, 0.0, 0.0));
    drop.setMin(Vec3D(-{{side}}, -{{side}}, -{{below}}));
    drop.setMax(Vec3D({{side}}, {{side}}, {{above}}));
    drop.setTimeStep({{step}}); // s
    drop.setTimeMax({{steps}} * {{step}});
    drop.setFileType(FileType::NO_FILE);
    drop.solve();
    std::cout << "drop at " << drop.speed << " m/s: e asked {{e}}, e measured "
              << drop.particleHandler.getObject(0)->getVelocity().Z / drop.speed << std::endl;
    return 0;
}
