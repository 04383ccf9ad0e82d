"""COCO's classes: their numbers and names, and how other programs number and name them."""

from corsmal.parameters import CONTAINER_CLASSES

_NAMES = (
    "person,bicycle,car,motorcycle,airplane,bus,train,truck,boat,traffic light,fire hydrant,,stop sign,parking meter,"
    "bench,bird,cat,dog,horse,sheep,cow,elephant,bear,zebra,giraffe,,backpack,umbrella,,,handbag,tie,suitcase,frisbee,"
    "skis,snowboard,sports ball,kite,baseball bat,baseball glove,skateboard,surfboard,tennis racket,bottle,,wine glass,"
    "cup,fork,knife,spoon,bowl,banana,apple,sandwich,orange,broccoli,carrot,hot dog,pizza,donut,cake,chair,couch,"
    "potted plant,bed,,dining table,,,toilet,,tv,laptop,mouse,remote,keyboard,cell phone,microwave,oven,toaster,sink,"
    "refrigerator,,book,clock,vase,scissors,teddy bear,hair drier,toothbrush"
)

CLASS_NAMES = {number: name for number, name in enumerate(_NAMES.split(","), start=1) if name}
"""COCO's 80 classes by number, which runs from 1 to 90 with gaps."""

CONSECUTIVE = tuple(CLASS_NAMES)
"""COCO's numbers in order: a program that counts the classes from 0 to 79 means the number in that place."""

_OTHER_NAMES = {
    "mug": 47,
    "beaker": 47,
    "glass": 46,
    "wineglass": 46,
    "champagne flute": 46,
    "drinking glass": 46,
    "box": 84,
    "cereal box": 84,
    "carton": 84,
    "container": 47,
    "can": 47,
    "jar": 86,
}
_NUMBERS = {name: number for number, name in CLASS_NAMES.items()} | _OTHER_NAMES

CLASS_MIN, CLASS_MAX = 1, max(CLASS_NAMES)


def class_number(name: str) -> int | None:
    """COCO's number of a class by its name, whatever its case and hyphens; None for a name that stands for none.

    Common names of containers that COCO lacks stand for the class that looks like them, such as ``mug`` for cup.
    """
    words = " ".join(name.lower().replace("_", " ").replace("-", " ").split())
    return _NUMBERS.get(words) or _NUMBERS.get(words.removesuffix("s"))


def class_text(number: int) -> str:
    """A class for people, such as ``41 (skateboard)``."""
    return f"{number} ({CLASS_NAMES[number]})" if number in CLASS_NAMES else str(number)


def no_container_hint(numbers: set[int]) -> str:
    """What else classes may mean of which none is a container: those of programs that count without gaps."""
    for first in (0, 1):
        meant = {
            number: CONSECUTIVE[number - first] for number in sorted(numbers) if 0 <= number - first < len(CONSECUTIVE)
        }
        found = [number for number, coco in meant.items() if coco in CONTAINER_CLASSES]
        if found:
            number = found[0]
            return (
                f" (counted without gaps from {first}, as YOLO's are, {number} is {CLASS_NAMES[meant[number]]}: "
                "write COCO's own numbers)"
            )
    return ""
